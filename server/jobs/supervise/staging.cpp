// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/supervise/supervise.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <new>

#include "protocol/base/system_error.h"
#include "storage/files/real_path.h"
#include "storage/grow_dataset.h"

namespace mote::server {
namespace {

namespace fs = std::filesystem;

constexpr int kMostFiles = 1'000'000;

/// Links would show what others have under this name; of other things nobody knows what they do. A file with
/// a second name may still be written to by whoever holds that.
bool isPlain(const struct stat& status) {
    if (S_ISDIR(status.st_mode)) return (status.st_mode & S_ISUID) == 0;
    return S_ISREG(status.st_mode) && status.st_nlink == 1 && (status.st_mode & (S_ISUID | S_ISGID)) == 0;
}

Status checkPlain(const fs::path& path) {
    struct stat status {};
    if (::lstat(path.c_str(), &status) != 0) return systemError(errno, path.string(), "cannot be looked at");
    if (isPlain(status)) return success();
    return Error{ErrorCode::corrupt, path.string(), "is neither a file nor a folder of the job's own"};
}

Status checkTree(const fs::path& top) {
    MOTE_RETURN_IF_ERROR(checkPlain(top));
    if (!fs::is_directory(top)) return success();
    std::error_code code;
    int count = 0;
    // It follows no links.
    for (fs::recursive_directory_iterator entry(top, code), end; !code && entry != end;
         entry.increment(code)) {
        if (++count > kMostFiles) return Error{ErrorCode::corrupt, top.string(), "holds too many files"};
        MOTE_RETURN_IF_ERROR(checkPlain(entry->path()));
    }
    if (code) return systemError(code.value(), top.string(), "cannot be looked through");
    return success();
}

/// Renames without replacing, where the file system can; 0 or an error number.
int renameNew(int from, const char* name, int to) {
    if (::renameat2(from, name, to, name, RENAME_NOREPLACE) == 0) return 0;
    if (errno != EINVAL && errno != ENOSYS) return errno;
    if (::faccessat(to, name, F_OK, AT_SYMLINK_NOFOLLOW) == 0) return EEXIST;
    return ::renameat(from, name, to, name) == 0 ? 0 : errno;
}

}  // namespace

Result<Staging> Staging::create(const fs::path& folder, const fs::path& output, bool grows) {
    MOTE_ASSIGN_OR_RETURN(auto parent, storage::openReal(output.parent_path(), O_RDONLY | O_DIRECTORY));
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    if (::mkdirat(parent.get(), folder.filename().c_str(), 0700) != 0)
        return systemError(errno, output.string(), "cannot be made");
    return Staging(std::move(parent), folder, output, grows);
}

Staging::~Staging() {
    if (!parent_.valid()) return;
    try {
        std::error_code ignored;
        fs::remove_all(folder_, ignored);
    } catch (const std::bad_alloc&) {
        // The server removes what a job has left.
    }
}

Status Staging::publish() {
    const auto name = output_.filename();
    std::error_code code;
    if (!fs::exists(fs::symlink_status(folder_ / name, code)))
        return Error{ErrorCode::notFound, "", "its output is not there, although the program ended well"};
    MOTE_RETURN_IF_ERROR(checkTree(folder_ / name));
    if (grows_ && fs::exists(fs::symlink_status(output_, code))) {
        MOTE_ASSIGN_OR_RETURN(const auto lock, storage::GrowthLock::take(output_));
        return storage::growDataset(folder_ / name, lock);
    }
    if (grows_) MOTE_RETURN_IF_ERROR(storage::checkBegins(folder_ / name));
    const storage::FileDescriptor folder(
        ::openat(parent_.get(), folder_.filename().c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (!folder.valid()) return systemError(errno, folder_.string(), "cannot be opened");
    const int number = renameNew(folder.get(), name.c_str(), parent_.get());
    if (number == EEXIST || number == ENOTEMPTY)
        return Error{ErrorCode::alreadyExists, output_.string(), "exists already and is never replaced"};
    if (number != 0) return systemError(number, output_.string(), "cannot be put in place");
    // EINVAL: a file system that cannot sync folders has nothing to do.
    if (::fsync(parent_.get()) == 0 || errno == EINVAL) return success();
    auto error = systemError(errno, output_.string(), "cannot be written to the disk");
    // A job that is said to have failed has left nothing.
    static_cast<void>(renameNew(parent_.get(), name.c_str(), folder.get()));
    return error;
}

}  // namespace mote::server
