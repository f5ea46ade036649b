// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/files/real_path.h"

#include <fcntl.h>
#include <linux/openat2.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>

#include "protocol/base/system_error.h"

namespace mote::storage {
namespace {

Error failure(int number, const std::filesystem::path& path) {
    if (number == ELOOP || number == ENOTDIR)
        return {ErrorCode::permissionDenied, path.string(), "was replaced by a link, which is not followed"};
    return systemError(number, path.string(), "cannot be opened");
}

}  // namespace

Result<FileDescriptor> openReal(const std::filesystem::path& path, int flags) {
    open_how how{};
    how.flags = static_cast<__u64>(flags | O_CLOEXEC);
    how.resolve = RESOLVE_NO_SYMLINKS;
    while (true) {
        const long opened = ::syscall(SYS_openat2, AT_FDCWD, path.c_str(), &how, sizeof how);
        if (opened >= 0) return FileDescriptor(static_cast<int>(opened));
        if (errno == ENOSYS) return walkReal(path, flags);
        if (errno != EINTR) return failure(errno, path);
    }
}

Result<FileDescriptor> walkReal(const std::filesystem::path& path, int flags) {
    const FileDescriptor top(::open("/", O_PATH | O_DIRECTORY | O_CLOEXEC));
    if (!top.valid()) return failure(errno, path);
    auto opened = walkRealAt(top.get(), path.relative_path(), flags);
    if (!opened.valid()) return failure(errno, path);
    return opened;
}

FileDescriptor openRealAt(int folder, const std::filesystem::path& path, int flags) {
    open_how how{};
    how.flags = static_cast<__u64>(flags | O_CLOEXEC);
    how.resolve = RESOLVE_NO_SYMLINKS | RESOLVE_BENEATH;
    while (true) {
        const long opened = ::syscall(SYS_openat2, folder, path.c_str(), &how, sizeof how);
        if (opened >= 0) return FileDescriptor(static_cast<int>(opened));
        if (errno == ENOSYS) return walkRealAt(folder, path, flags);
        if (errno != EINTR) return {};
    }
}

FileDescriptor walkRealAt(int folder, const std::filesystem::path& path, int flags) {
    FileDescriptor opened;
    for (auto part = path.begin(); part != path.end(); ++part) {
        const bool last = std::next(part) == path.end();
        // Of a link O_PATH | O_NOFOLLOW alone opens the link itself.
        const int how = last ? flags | O_NOFOLLOW : O_PATH | O_DIRECTORY | O_NOFOLLOW;
        const int parent = opened.valid() ? opened.get() : folder;
        opened = FileDescriptor(::openat(parent, part->c_str(), how | O_CLOEXEC));
        if (!opened.valid()) return {};
    }
    struct stat status {};
    if (!opened.valid() || ::fstat(opened.get(), &status) != 0) return {};
    if (!S_ISLNK(status.st_mode)) return opened;
    errno = ELOOP;
    return {};
}

}  // namespace mote::storage
