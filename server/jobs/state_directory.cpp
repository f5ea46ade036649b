// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/state_directory.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <thread>
#include <utility>

#include "protocol/base/system_error.h"
#include "server/jobs/job_settings.h"
#include "server/jobs/job_store.h"

namespace mote::server {
namespace {

constexpr std::chrono::milliseconds kLockPatience(500), kLockPause(5);

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

/// A server that was just killed keeps its lock until the kernel has taken it apart.
bool lockSoon(int file) {
    const auto end = std::chrono::steady_clock::now() + kLockPatience;
    while (flock(file, LOCK_EX | LOCK_NB) != 0) {
        if (std::chrono::steady_clock::now() >= end) return false;
        std::this_thread::sleep_for(kLockPause);
    }
    return true;
}

storage::FileDescriptor openOwn(const std::filesystem::path& file) {
    return storage::FileDescriptor(open(file.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0600));
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

Result<StateDirectory> StateDirectory::open(std::filesystem::path place) {
    std::error_code code;
    std::filesystem::create_directories(place.parent_path(), code);
    // The user may have put a link in its place; in the directory itself there is none.
    if (auto real = std::filesystem::canonical(place, code); !code) place = std::move(real);
    for (const auto& folder : {place, place / "jobs", filmConnectionFile(place).parent_path()})
        MOTE_RETURN_IF_ERROR(makeOwnFolder(folder));
    for (const char* file : {"jobs.lock", "jobs.sqlite", "jobs.sqlite-wal", "jobs.sqlite-shm",
                             "jobs.copy.sqlite", "jobs.copy.sqlite-wal", "jobs.copy.sqlite-shm"})
        MOTE_RETURN_IF_ERROR(checkOwnFile(place / file));
    StateDirectory state;
    state.path_ = std::filesystem::canonical(place, code);
    if (code) return refused(place, code.message());
    state.lock_ = openOwn(state.path_ / "jobs.lock");
    if (!state.lock_.valid()) return refused(state.path_ / "jobs.lock", systemMessage(errno));
    if (!lockSoon(state.lock_.get())) {
        return Error{ErrorCode::alreadyExists, state.path_.string(),
                     "another server uses this state directory"};
    }
    // SQLite would take the umask's mode, and give its other files that of this one.
    openOwn(state.database());
    openOwn(JobStore::copyOf(state.database()));
    return state;
}

}  // namespace mote::server
