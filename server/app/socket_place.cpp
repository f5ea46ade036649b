// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/socket_place.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "protocol/scene/system_error.h"
#include "protocol/wire/address.h"

namespace mote::server {
namespace {

namespace fs = std::filesystem;

constexpr const char* socketName = "mote.sock";

Status removeStale(const fs::path& path) {
    struct stat status {};
    if (::lstat(path.c_str(), &status) != 0) {
        if (errno == ENOENT) return success();
        return Error{ErrorCode::permissionDenied, path.string(), systemMessage(errno)};
    }
    if (!S_ISSOCK(status.st_mode)) {
        return Error{ErrorCode::alreadyExists, path.string(),
                     "is no socket but stands where the server's socket belongs; move it away"};
    }
    if (::unlink(path.c_str()) == 0) return success();
    return Error{ErrorCode::permissionDenied, path.string(), systemMessage(errno)};
}

/// XDG_RUNTIME_DIR, the user's alone and short on every system that has it; else the folder for temporary
/// files.
fs::path runtimeFolder() {
    const char* folder = ::secure_getenv("XDG_RUNTIME_DIR");
    if (folder && *folder == '/' && ::access(folder, W_OK) == 0) return folder;
    std::error_code code;
    const auto temporary = fs::temp_directory_path(code);
    return code ? fs::path("/tmp") : temporary;
}

}  // namespace

SocketPlace::~SocketPlace() {
    if (path_.empty()) return;
    ::unlink(path_.c_str());
    if (!folder_.empty()) ::rmdir(folder_.c_str());
}

Result<SocketPlace> SocketPlace::make(const fs::path& stateDirectory) {
    std::error_code code;
    const fs::path wanted = fs::absolute(stateDirectory, code) / socketName;
    if (wanted.native().size() <= wire::maxSocketPath) {
        MOTE_RETURN_IF_ERROR(removeStale(wanted));
        return SocketPlace(wanted, {});
    }
    std::string folder = (runtimeFolder() / "mote-XXXXXX").string();
    if (folder.size() + 1 + std::strlen(socketName) > wire::maxSocketPath) {
        return Error{ErrorCode::invalidArgument, wanted.string(),
                     fmt::format("a socket's path has at most {} bytes; give --state a shorter one",
                                 wire::maxSocketPath)};
    }
    if (!::mkdtemp(folder.data())) {
        return Error{ErrorCode::internal, folder, fmt::format("cannot be made: {}", systemMessage(errno))};
    }
    return SocketPlace(fs::path(folder) / socketName, folder);
}

}  // namespace mote::server
