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
#include "protocol/base/complain.h"
#include "protocol/base/json.h"

namespace mote::client {
namespace {

std::filesystem::path cacheFolder() {
    const char* cache = std::getenv("XDG_CACHE_HOME");
    if (cache != nullptr && cache[0] == '/') return std::filesystem::path(cache) / "mote";
    const char* home = std::getenv("HOME");
    return std::filesystem::path(home != nullptr ? home : ".") / ".cache/mote";
}

/// Lines that a program writes into a pipe of ours.
class HeardLines {
  public:
    ~HeardLines() { close(); }

    /// The end for the program, which the caller closes; below 0: there are no pipes.
    int open() {
        int ends[2];
        if (::pipe2(ends, O_CLOEXEC) != 0) return -1;
        pipe_ = ends[0];
        return ends[1];
    }
    bool isOpen() const { return pipe_ >= 0; }
    /// Whole lines that came since; of one that is too long its beginning.
    std::vector<std::string> take() {
        constexpr std::size_t mostLetters = 2000;
        std::vector<std::string> lines;
        struct pollfd watched {
            pipe_, POLLIN, 0
        };
        while (isOpen() && ::poll(&watched, 1, 0) > 0) {
            std::array<char, 4096> bytes{};
            const auto count = ::read(pipe_, bytes.data(), bytes.size());
            if (count < 0 && errno == EINTR) continue;
            if (count <= 0) close();
            for (ssize_t i = 0; i < count; ++i) {
                const char letter = bytes[static_cast<std::size_t>(i)];
                if (letter == '\n') lines.push_back(std::exchange(line_, {}));
                if (letter != '\n' && line_.size() < mostLetters) line_ += letter;
            }
        }
        return lines;
    }

  private:
    void close() {
        if (pipe_ >= 0) ::close(std::exchange(pipe_, -1));
    }

    int pipe_ = -1;
    std::string line_;
};

/// mote-prep, which says on stderr what it does and tells its progress beside it; it does not outlive this.
class PreparingProgram {
  public:
    ~PreparingProgram() {
        if (process_ <= 0) return;
        ::kill(process_, SIGTERM);
        wait();
    }

    Status start(const std::filesystem::path& program, std::vector<std::string> words) {
        const int saying = said.open(), telling = told.open();
        std::vector<char*> arguments;
        arguments.reserve(words.size() + 1);
        for (auto& word : words) arguments.push_back(word.data());
        arguments.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        ::posix_spawn_file_actions_init(&actions);
        ::posix_spawn_file_actions_adddup2(&actions, saying, STDERR_FILENO);
        ::posix_spawn_file_actions_adddup2(&actions, telling, progressDescriptor);
        const bool piped = saying >= 0 && telling >= 0;
        const int failure =
            piped ? ::posix_spawn(&process_, program.c_str(), &actions, nullptr, arguments.data(), environ)
                  : EMFILE;
        ::posix_spawn_file_actions_destroy(&actions);
        if (saying >= 0) ::close(saying);
        if (telling >= 0) ::close(telling);
        if (failure == 0) return success();
        process_ = 0;
        if (!piped) return Error{ErrorCode::internal, program.string(), "there is no pipe for what it says"};
        return Error{ErrorCode::notFound, program.string(), "there is no program here that prepares files"};
    }

    /// Its exit status, once it has ended; -1: by a signal.
    int wait() {
        int status = 0;
        while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
        }
        process_ = 0;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }

    static constexpr int progressDescriptor = 3;  ///< its own
    HeardLines said, told;

  private:
    pid_t process_ = 0;
};

/// A sign in the window: what is prepared, for how long now, and what was chosen. False: the user wants none
/// of it.
bool drawPreparing(Window& window, const std::string& name, const proto::JobProgress& progress,
                   const std::deque<std::string>& said) {
    window.beginFrame(0.1);
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({display.x / 2.0F, display.y / 2.0F}, ImGuiCond_Always, {0.5F, 0.5F});
    ImGui::SetNextWindowSize({std::min(640.0F * window.contentScale(), display.x), 0.0F});
    ImGui::Begin("preparing", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove);
    text(fmt::format("Preparing {}, {:.0f} s", name, ImGui::GetTime()));
    const auto done = progress.phase().empty()
                          ? std::string("looking at it")
                          : fmt::format("{:.0f}%  {}", 100.0 * progress.progress(), progress.phase());
    ImGui::ProgressBar(static_cast<float>(progress.progress()), {-1.0F, 0.0F}, done.c_str());
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
    constexpr std::size_t mostLines = 8;
    constexpr std::string_view speaker = "mote-prep: ";
    const auto path = serverBesideUs().parent_path() / "mote-prep";
    PreparingProgram program;
    MOTE_RETURN_IF_ERROR(
        program.start(path, {path.string(), "auto", file.string(), "--out", dataset.string(), "--progress-fd",
                             std::to_string(PreparingProgram::progressDescriptor)}));
    std::deque<std::string> said;
    proto::JobProgress progress;
    while (program.said.isOpen()) {
        for (auto& line : program.said.take()) {
            if (line.starts_with(speaker)) line.erase(0, speaker.size());
            complain("mote-prep", line);
            said.push_back(std::move(line));
            if (said.size() > mostLines) said.pop_front();
        }
        for (const auto& line : program.told.take()) {
            proto::JobProgress told;
            if (parseJson(line, told, "progress").ok()) progress = std::move(told);
        }
        if (!drawPreparing(window, file.filename().string(), progress, said))
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

Status startServer(ViewOptions& options) {
    sigset_t before;
    ::pthread_sigmask(SIG_BLOCK, nullptr, &before);
    auto started = [&] {
        const Interrupt interrupt;
        return PrivateServer::launch("mote-view", {serverBesideUs(), options.spawn, {}, 0}, interrupt);
    }();
    // Signals end this program again, and what prepares a file for it.
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
    MOTE_RETURN_IF_ERROR(started);
    options.server = *std::move(started);
    return success();
}

Status resolveTarget(ViewOptions& options) {
    std::error_code code;
    const auto path = std::filesystem::canonical(*options.target, code);
    if (code) return Error{ErrorCode::notFound, options.target->string(), "there is no such file or folder"};
    auto dataset = path;
    const bool folder = std::filesystem::is_directory(path, code) && path.extension() != ".mote";
    const bool raw = !folder && path.extension() != ".mote";
    if (raw) {
        const auto cache = cacheFolder();
        std::filesystem::create_directories(cache, code);
        if (code)
            return Error{ErrorCode::permissionDenied, cache.string(),
                         "a folder for what is prepared is needed here"};
        dataset = cache / (cachedName(path) + ".mote");
    }
    options.spawn.push_back("data=" + (folder ? path : dataset.parent_path()).string());
    MOTE_RETURN_IF_ERROR(startServer(options));
    if (folder) return success();
    if (raw && !std::filesystem::exists(dataset, code)) {
        options.window = std::make_shared<Window>(options.width, options.height, "Mote");
        MOTE_RETURN_IF_ERROR(prepare(path, dataset, *options.window));
    }
    options.dataset = "data/" + dataset.stem().string();
    // A view that was chosen for it lies beside it, of this root.
    const auto view = std::filesystem::path(dataset).replace_extension(".view.json");
    if (!options.view && std::filesystem::exists(view, code)) options.view = view;
    return success();
}

}  // namespace mote::client
