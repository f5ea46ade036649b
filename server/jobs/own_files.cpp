// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/own_files.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "protocol/scene/system_error.h"

namespace mote::server {
namespace {

Error refused(const std::filesystem::path& path, std::string why) {
    return {ErrorCode::permissionDenied, path.string(), std::move(why)};
}

/// Of what is there, as lstat tells it.
Status checkOwner(const std::filesystem::path& path, const struct stat& status) {
    if (S_ISLNK(status.st_mode)) return refused(path, "is a link, where the server keeps its own files");
    if (status.st_uid != ::geteuid()) {
        return refused(path, fmt::format("belongs to another user (number {}): give --state a directory of "
                                         "your own",
                                         status.st_uid));
    }
    if ((status.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
        return refused(path, "others may write to it: look through it, then take that right with chmod go-w");
    }
    return success();
}

}  // namespace

Status makeOwnFolder(const std::filesystem::path& folder) {
    if (::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST)
        return refused(folder, fmt::format("cannot be made: {}", systemMessage(errno)));
    return checkOwnFolder(folder);
}

Status checkOwnFolder(const std::filesystem::path& folder) {
    struct stat status {};
    if (::lstat(folder.c_str(), &status) != 0) return refused(folder, systemMessage(errno));
    MOTE_RETURN_IF_ERROR(checkOwner(folder, status));
    return S_ISDIR(status.st_mode) ? success() : Status(refused(folder, "is no directory"));
}

Status checkOwnFile(const std::filesystem::path& file) {
    struct stat status {};
    if (::lstat(file.c_str(), &status) != 0) {
        return errno == ENOENT ? success() : Status(refused(file, systemMessage(errno)));
    }
    MOTE_RETURN_IF_ERROR(checkOwner(file, status));
    return S_ISREG(status.st_mode) ? success() : Status(refused(file, "is no regular file"));
}

}  // namespace mote::server
