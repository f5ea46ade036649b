// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/part_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <cstdio>

#include "protocol/base/json.h"
#include "protocol/base/system_error.h"

namespace mote::client {
namespace {

bool isNamed(int file, const std::filesystem::path& path) {
    struct stat mine {
    }, named{};
    return ::fstat(file, &mine) == 0 && ::lstat(path.c_str(), &named) == 0 && mine.st_dev == named.st_dev &&
           mine.st_ino == named.st_ino;
}

/// An open, locked file of that name; or -1, with errno (EWOULDBLOCK: of another process). File systems
/// without locks do without.
int openLocked(const std::filesystem::path& path) {
    constexpr int mostTries = 100;  // each fails only where another process ends in between
    for (int i = 0; i < mostTries; ++i) {
        const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
        if (file < 0) return file;
        const bool busy = ::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
        if (!busy && isNamed(file, path)) return file;
        ::close(file);
        errno = EWOULDBLOCK;
        if (busy) return -1;
    }
    return -1;
}

/// Fails with EEXIST where there is anything of that name. File systems that cannot do so in one step have a
/// link, or are looked at first.
bool renameToNew(const std::filesystem::path& from, const std::filesystem::path& to) {
    if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return true;
    if (errno != EINVAL && errno != ENOSYS && errno != ENOTSUP) return false;
    if (::link(from.c_str(), to.c_str()) == 0) return ::unlink(from.c_str()) == 0;
    if (errno == EEXIST) return false;
    struct stat named {};
    if (::lstat(to.c_str(), &named) != 0) return errno == ENOENT && ::rename(from.c_str(), to.c_str()) == 0;
    errno = EEXIST;
    return false;
}

}  // namespace

Result<std::unique_ptr<PartFile>> PartFile::create(const std::filesystem::path& path) {
    std::error_code code;
    if (path.filename().empty() || std::filesystem::is_directory(path, code)) {
        return Error{ErrorCode::alreadyExists, path.string(), "is a folder, where a file should be written"};
    }
    const auto hidden = path.parent_path() / fmt::format(".{}.part", path.filename().string());
    const int file = openLocked(hidden);
    if (file < 0 && errno == EWOULDBLOCK) {
        return Error{ErrorCode::alreadyExists, path.string(), "is being written by another process"};
    }
    if (file < 0) return systemError(errno, path.string(), "cannot be written");
    std::unique_ptr<PartFile> part(new PartFile(path, hidden, file));
    if (::ftruncate(file, 0) != 0) return systemError(errno, path.string(), "cannot be written");
    return part;
}

PartFile::PartFile(std::filesystem::path path, std::filesystem::path hidden, int file)
    : path_(std::move(path)), hidden_(std::move(hidden)), file_(file) {}

PartFile::~PartFile() {
    if (!published_) ::unlink(hidden_.c_str());
    ::close(file_);
}

Status PartFile::append(std::span<const std::uint8_t> bytes) {
    if (::lseek(file_, 0, SEEK_END) < 0) return systemError(errno, path_.string(), "cannot be written");
    return write(bytes);
}

Status PartFile::overwrite(std::uint64_t begin, std::span<const std::uint8_t> bytes) {
    if (::lseek(file_, static_cast<off_t>(begin), SEEK_SET) < 0)
        return systemError(errno, path_.string(), "cannot be written");
    return write(bytes);
}

Status PartFile::write(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
        const auto written = ::write(file_, bytes.data(), bytes.size());
        if (written >= 0) bytes = bytes.subspan(static_cast<std::size_t>(written));
        if (written < 0 && errno != EINTR) return systemError(errno, path_.string(), "cannot be written");
    }
    return success();
}

Status PartFile::sync() {
    const bool kept = ::fsync(file_) == 0 || errno == EINVAL || errno == EROFS || errno == ENOTSUP;
    return kept ? success() : systemError(errno, path_.string(), "cannot be written");
}

/// A network file system may say only at a close that a write failed; the file stays open for its lock.
Status PartFile::closeCopy() {
    const int copy = ::dup(file_);
    if (copy < 0 || ::close(copy) != 0) return systemError(errno, path_.string(), "cannot be written");
    return success();
}

Status PartFile::publishNew() {
    MOTE_RETURN_IF_ERROR(closeCopy());
    if (renameToNew(hidden_, path_)) {
        published_ = true;
        return success();
    }
    if (errno != EEXIST) return systemError(errno, path_.string(), "cannot be written");
    return Error{ErrorCode::alreadyExists, path_.string(), "is there already"};
}

Status PartFile::publish() {
    MOTE_RETURN_IF_ERROR(closeCopy());
    if (::rename(hidden_.c_str(), path_.c_str()) != 0) {
        return systemError(errno, path_.string(), "cannot be written");
    }
    published_ = true;
    return success();
}

Status saveJson(const std::filesystem::path& path, const google::protobuf::Message& message,
                SameName sameName) {
    const auto text = toJson(message);
    MOTE_ASSIGN_OR_RETURN(const auto part, PartFile::create(path));
    MOTE_RETURN_IF_ERROR(part->append({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}));
    MOTE_RETURN_IF_ERROR(part->sync());
    return sameName == SameName::stays ? part->publishNew() : part->publish();
}

}  // namespace mote::client
