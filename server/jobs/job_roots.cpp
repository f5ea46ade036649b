// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_roots.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/openat2.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "server/jobs/file_descriptor.h"

namespace mote::server {
namespace {

constexpr std::size_t kLongestName = 1024;      // bytes of "ROOT/PATH"
constexpr std::size_t kLongestComponent = 255;  // NAME_MAX

Error badName(std::string_view field, std::string message) {
    return {ErrorCode::invalidArgument, std::string(field), std::move(message)};
}

bool hasControlCharacter(std::string_view text) {
    return std::any_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
}

Status checkComponents(std::string_view path, std::string_view field) {
    while (true) {
        const auto slash = path.find('/');
        const auto part = path.substr(0, slash);
        if (part.empty() || part == "." || part == "..") {
            return badName(field, "must be ROOT/PATH without empty parts, \".\" or \"..\"");
        }
        if (part.size() > kLongestComponent) {
            return badName(field, fmt::format("has a part of more than {} bytes", kLongestComponent));
        }
        if (slash == std::string_view::npos) return success();
        path.remove_prefix(slash + 1);
    }
}

/// An O_PATH descriptor beneath the root; -1 with errno.
int openBeneath(int root, const char* path) {
    open_how how{};
    how.flags = O_PATH | O_CLOEXEC;
    how.resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS;
    for (int attempt = 0; attempt < 100; ++attempt) {  // EAGAIN: something was renamed meanwhile
        const int fd = static_cast<int>(syscall(SYS_openat2, root, path, &how, sizeof how));
        if (fd >= 0 || (errno != EAGAIN && errno != EINTR)) return fd;
    }
    return -1;
}

}  // namespace

Result<JobRoots> JobRoots::parse(const std::vector<std::string>& texts) {
    JobRoots roots;
    for (const auto& text : texts) {
        const auto equals = text.find('=');
        const auto name = text.substr(0, equals);
        if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
            return Error{ErrorCode::invalidArgument, "--root", fmt::format("\"{}\" is not NAME=DIR", text)};
        }
        if (name.find('/') != std::string::npos || name == "." || name == ".." || hasControlCharacter(name)) {
            return Error{ErrorCode::invalidArgument, "--root",
                         fmt::format("\"{}\" cannot name a root", name)};
        }
        const auto same = [&](const Root& root) { return root.name == name; };
        if (std::any_of(roots.roots_.begin(), roots.roots_.end(), same)) {
            return Error{ErrorCode::invalidArgument, "--root", fmt::format("\"{}\" is given twice", name)};
        }
        std::error_code code;
        auto folder = std::filesystem::canonical(text.substr(equals + 1), code);
        if (code || !std::filesystem::is_directory(folder, code)) {
            return Error{ErrorCode::notFound, "--root",
                         fmt::format("{} is not a folder", text.substr(equals + 1))};
        }
        roots.roots_.push_back({name, std::move(folder)});
    }
    return roots;
}

Result<JobRoots::Place> JobRoots::locate(std::string_view name, std::string_view field) const {
    if (name.size() > kLongestName) {
        return badName(field, fmt::format("is longer than {} bytes", kLongestName));
    }
    if (hasControlCharacter(name)) return badName(field, "holds a control character");
    const auto slash = name.find('/');
    if (slash == std::string_view::npos) return badName(field, "must be ROOT/PATH");
    const auto relative = name.substr(slash + 1);
    MOTE_RETURN_IF_ERROR(checkComponents(relative, field));
    for (const auto& root : roots_) {
        if (root.name == name.substr(0, slash)) return Place{root.folder, std::filesystem::path(relative)};
    }
    return Error{ErrorCode::notFound, std::string(field),
                 fmt::format("\"{}\" is no root of this server", name.substr(0, slash))};
}

Result<bool> JobRoots::exists(const Place& place, std::string_view field) {
    const FileDescriptor root(open(place.root.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
    const FileDescriptor file(root.valid() ? openBeneath(root.get(), place.relative.c_str()) : -1);
    if (file.valid()) return true;
    const int error = errno;
    if (error == ENOENT) return false;
    if (error == EXDEV || error == ELOOP || error == ENOTDIR || error == ENAMETOOLONG) {
        return badName(field, error == EXDEV ? "leads out of its root" : std::strerror(error));
    }
    const auto kind = error == EACCES ? ErrorCode::permissionDenied : ErrorCode::internal;
    return Error{kind, std::string(field), std::strerror(error)};
}

std::vector<std::string> JobRoots::options() const {
    std::vector<std::string> texts;
    for (const auto& root : roots_) texts.push_back(root.name + "=" + root.folder.string());
    return texts;
}

std::vector<std::filesystem::path> JobRoots::folders() const {
    std::vector<std::filesystem::path> folders;
    for (const auto& root : roots_) folders.push_back(root.folder);
    return folders;
}

}  // namespace mote::server
