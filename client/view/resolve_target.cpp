// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is shown without a server of the user's: where it lies, and how it is made.
#include <fmt/format.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <vector>

#include "client/shared/server_line.h"
#include "client/view/desk.h"
#include "client/view/viewer.h"

namespace mote::client {
namespace {

std::filesystem::path cacheFolder() {
    const char* cache = std::getenv("XDG_CACHE_HOME");
    if (cache != nullptr && cache[0] == '/') return std::filesystem::path(cache) / "mote";
    const char* home = std::getenv("HOME");
    return std::filesystem::path(home != nullptr ? home : ".") / ".cache/mote";
}

/// Lets mote-prep choose what the file becomes, and make it; what it says, the user sees. Errors: notFound,
/// invalidArgument.
Status prepare(const std::filesystem::path& file, const std::filesystem::path& dataset) {
    const auto program = serverBesideUs().parent_path() / "mote-prep";
    std::string words[] = {program.string(), "auto", file.string(), "--out", dataset.string()};
    std::vector<char*> arguments;
    for (auto& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    pid_t child = 0;
    if (const int failure =
            ::posix_spawn(&child, program.c_str(), nullptr, nullptr, arguments.data(), environ);
        failure != 0)
        return Error{ErrorCode::notFound, program.string(), "there is no program here that prepares files"};
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return success();
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
        if (!std::filesystem::exists(dataset, code)) MOTE_RETURN_IF_ERROR(prepare(path, dataset));
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
