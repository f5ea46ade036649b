// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/files/real_path.h"

#include <fcntl.h>
#include <linux/openat2.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>

#include "protocol/scene/system_error.h"

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
    FileDescriptor folder(::open("/", O_PATH | O_DIRECTORY | O_CLOEXEC));
    const auto parts = path.relative_path();
    for (auto part = parts.begin(); folder.valid() && part != parts.end(); ++part) {
        const bool last = std::next(part) == parts.end();
        // Of a link O_PATH | O_NOFOLLOW alone opens the link itself.
        const int how = last ? flags | O_NOFOLLOW : O_PATH | O_DIRECTORY | O_NOFOLLOW;
        folder = FileDescriptor(::openat(folder.get(), part->c_str(), how | O_CLOEXEC));
    }
    if (!folder.valid()) return failure(errno, path);
    struct stat status {};
    if (::fstat(folder.get(), &status) != 0) return failure(errno, path);
    if (S_ISLNK(status.st_mode)) return failure(ELOOP, path);
    return folder;
}

}  // namespace mote::storage
