// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is shown without a server of the user's: where it lies, and how it is made.
#include <fcntl.h>
#include <fmt/format.h>
#include <imgui.h>
#include <poll.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/shared/server_line.h"
#include "client/view/desk.h"
#include "client/view/panel_widgets.h"
#include "client/view/viewer.h"
#include "protocol/scene/complain.h"

namespace mote::client {
namespace {

std::filesystem::path cacheFolder() {
    const char* cache = std::getenv("XDG_CACHE_HOME");
    if (cache != nullptr && cache[0] == '/') return std::filesystem::path(cache) / "mote";
    const char* home = std::getenv("HOME");
    return std::filesystem::path(home != nullptr ? home : ".") / ".cache/mote";
}

/// A program that was started with its stderr in a pipe; it does not outlive this.
class PreparingProgram {
  public:
    ~PreparingProgram() {
        if (pipe_ >= 0) ::close(pipe_);
        if (process_ <= 0) return;
        ::kill(process_, SIGTERM);
        wait();
    }

    Status start(const std::filesystem::path& program, std::vector<std::string> words) {
        int ends[2];
        if (::pipe2(ends, O_CLOEXEC) != 0)
            return Error{ErrorCode::internal, program.string(), "there is no pipe for what it says"};
        pipe_ = ends[0];
        std::vector<char*> arguments;
        for (auto& word : words) arguments.push_back(word.data());
        arguments.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        ::posix_spawn_file_actions_init(&actions);
        ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
        const int failure =
            ::posix_spawn(&process_, program.c_str(), &actions, nullptr, arguments.data(), environ);
        ::posix_spawn_file_actions_destroy(&actions);
        ::close(ends[1]);
        if (failure == 0) return success();
        process_ = 0;
        return Error{ErrorCode::notFound, program.string(), "there is no program here that prepares files"};
    }

    /// What it has said by now; nothing once it says no more.
    std::optional<std::string> hear() {
        struct pollfd watched {
            pipe_, POLLIN, 0
        };
        if (::poll(&watched, 1, 0) <= 0) return std::string();
        std::array<char, 4096> bytes{};
        const auto count = ::read(pipe_, bytes.data(), bytes.size());
        if (count > 0) return std::string(bytes.data(), static_cast<std::size_t>(count));
        return count < 0 && errno == EINTR ? std::optional(std::string()) : std::nullopt;
    }

    /// Its exit status, once it has ended; -1: by a signal.
    int wait() {
        int status = 0;
        while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
        }
        process_ = 0;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }

  private:
    pid_t process_ = 0;
    int pipe_ = -1;
};

/// A sign in the window: what is prepared, for how long now, and what was chosen. False: the user wants none
/// of it.
bool drawPreparing(Window& window, const std::string& name, const std::deque<std::string>& said) {
    window.beginFrame(0.1);
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({display.x / 2.0F, display.y / 2.0F}, ImGuiCond_Always, {0.5F, 0.5F});
    ImGui::SetNextWindowSize({std::min(640.0F * window.contentScale(), display.x), 0.0F});
    ImGui::Begin("preparing", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove);
    text(fmt::format("Preparing {}, {:.0f} s", name, ImGui::GetTime()));
    for (const auto& line : said) dim(line);
    const bool cancelled = ImGui::Button("Cancel");
    ImGui::End();
    window.drawFrame();
    window.presentFrame();
    return !cancelled && !window.shouldClose();
}

/// Lets mote-prep choose what the file becomes, and make it; what it says, the user sees. Errors: notFound,
/// invalidArgument, cancelled.
Status prepare(const std::filesystem::path& file, const std::filesystem::path& dataset, Window& window) {
    constexpr std::size_t mostLines = 8, mostLetters = 2000;
    constexpr std::string_view speaker = "mote-prep: ";
    const auto path = serverBesideUs().parent_path() / "mote-prep";
    PreparingProgram program;
    MOTE_RETURN_IF_ERROR(
        program.start(path, {path.string(), "auto", file.string(), "--out", dataset.string()}));
    std::deque<std::string> said;
    std::string line;
    for (auto heard = program.hear(); heard; heard = program.hear()) {
        for (const char letter : *heard) {
            if (letter != '\n' && line.size() < mostLetters) line += letter;
            if (letter != '\n') continue;
            if (line.starts_with(speaker)) line.erase(0, speaker.size());
            complain("mote-prep", line);
            said.push_back(std::exchange(line, {}));
            if (said.size() > mostLines) said.pop_front();
        }
        if (!drawPreparing(window, file.filename().string(), said))
            return Error{ErrorCode::cancelled, file.string(), "it was not prepared, as you wished"};
    }
    if (program.wait() == 0) return success();
    return invalid(file.string(), "it could not be prepared; mote-prep said why");
}

/// A name that another file, or the same one changed, does not have.
std::string cachedName(const std::filesystem::path& file) {
    struct stat facts {};
    static_cast<void>(::stat(file.c_str(), &facts));
    const auto key = sessionKey(fmt::format("{}/{}-{}-{}", file.string(), facts.st_size, facts.st_mtim.tv_sec,
                                            facts.st_mtim.tv_nsec));
    std::string stem = file.filename().string();
    stem = stem.substr(0, stem.find('.'));
    std::ranges::replace_if(
        stem, [](unsigned char c) { return std::isalnum(c) == 0 && c != '-' && c != '_'; }, '-');
    return fmt::format("{}-{}", stem.empty() ? "run" : stem, key.substr(0, 8));
}

}  // namespace

Status resolveTarget(ViewOptions& options) {
    std::error_code code;
    const auto path = std::filesystem::canonical(*options.target, code);
    if (code) return Error{ErrorCode::notFound, options.target->string(), "there is no such file or folder"};
    auto dataset = path;
    const bool folder = std::filesystem::is_directory(path, code) && path.extension() != ".mote";
    if (!folder && path.extension() != ".mote") {
        const auto cache = cacheFolder();
        std::filesystem::create_directories(cache, code);
        if (code)
            return Error{ErrorCode::permissionDenied, cache.string(),
                         "a folder for what is prepared is needed here"};
        dataset = cache / (cachedName(path) + ".mote");
        if (!std::filesystem::exists(dataset, code)) {
            options.window = std::make_shared<Window>(options.width, options.height, "Mote");
            MOTE_RETURN_IF_ERROR(prepare(path, dataset, *options.window));
        }
    }
    options.spawn.push_back("data=" + (folder ? path : dataset.parent_path()).string());
    if (folder) return success();
    options.dataset = "data/" + dataset.stem().string();
    // A view that was chosen for it lies beside it, of this root.
    const auto view = std::filesystem::path(dataset).replace_extension(".view.json");
    if (!options.view && std::filesystem::exists(view, code)) options.view = view;
    return success();
}

}  // namespace mote::client
