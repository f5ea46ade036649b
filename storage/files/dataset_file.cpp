// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/files/dataset_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/magic.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>

#include "protocol/base/system_error.h"
#include "storage/files/file_descriptor.h"

namespace mote::storage {
namespace {

constexpr std::size_t most = std::size_t{1} << 30;  // bytes; the kernel takes less than 2 GiB at once

constexpr int pastCache = 0x80;  // RWF_DONTCACHE, which older headers lack

/// Whether an error says that the kernel, its file system or who confines us knows no such call.
bool isUnknown(int number) {
    return number == EOPNOTSUPP || number == EINVAL || number == ENOSYS;
}

ssize_t writeSome(int descriptor, std::uint64_t offset, std::span<const std::byte> bytes, PageCache cache) {
    const std::size_t size = std::min(bytes.size(), most);
    if (cache == PageCache::passed) {
        const iovec part{const_cast<std::byte*>(bytes.data()), size};
        const ssize_t wrote = ::pwritev2(descriptor, &part, 1, static_cast<off_t>(offset), pastCache);
        if (wrote >= 0 || !isUnknown(errno)) return wrote;
    }
    return ::pwrite(descriptor, bytes.data(), size, static_cast<off_t>(offset));
}

constexpr std::size_t leastBrought = std::size_t{1} << 18;

std::filesystem::path folderOf(const std::filesystem::path& path) {
    const auto folder = path.parent_path();
    return folder.empty() ? std::filesystem::path(".") : folder;
}

/// Renames without replacing; 0 or an error number.
int renameNew(const std::filesystem::path& from, const std::filesystem::path& to) {
    if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
    if (errno != EINVAL && errno != ENOSYS) return errno;
    // File systems without RENAME_NOREPLACE (some network ones): look, then rename. A folder with content is
    // not replaced by rename(2) either way.
    if (::faccessat(AT_FDCWD, to.c_str(), F_OK, AT_SYMLINK_NOFOLLOW) == 0) return EEXIST;
    return ::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
}

}  // namespace

bool isInMemory(int descriptor) {
    struct statfs status {};
    return ::fstatfs(descriptor, &status) == 0 && status.f_type == TMPFS_MAGIC;
}

void bringPages(int descriptor, std::uint64_t offset, std::size_t size) {
    if (size < leastBrought || !isInMemory(descriptor)) return;
    static const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
    const std::uint64_t begin = offset / page * page, bytes = offset + size - begin;
    void* const at =
        ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, static_cast<off_t>(begin));
    if (at == MAP_FAILED) return;
    ::madvise(at, bytes, MADV_POPULATE_WRITE);
    ::munmap(at, bytes);
}

bool isPlainName(const std::string& name) {
    return !name.empty() && name.size() <= 255 && name != "." && name != ".." &&
           name.find('/') == std::string::npos && name.find('\0') == std::string::npos;
}

Result<std::unique_ptr<ScratchFile>> ScratchFile::create(const std::filesystem::path& path) {
    FileDescriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (!file.valid()) return systemError(errno, path.string(), "cannot be made");
    return std::unique_ptr<ScratchFile>(new ScratchFile(path, std::move(file), true));
}

Result<std::unique_ptr<ScratchFile>> ScratchFile::open(const std::filesystem::path& path) {
    FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file.valid()) return systemError(errno, path.string(), "cannot be opened");
    return std::unique_ptr<ScratchFile>(new ScratchFile(path, std::move(file), false));
}

ScratchFile::~ScratchFile() {
    if (own_) ::unlink(path_.c_str());
}

Result<std::uint64_t> ScratchFile::append(std::span<const std::byte> bytes) {
    const auto at = end_.fetch_add(bytes.size());
    MOTE_RETURN_IF_ERROR(writeAt(file_.get(), at, bytes, path_));
    return at;
}

Status ScratchFile::read(std::uint64_t at, std::span<std::byte> bytes) const {
    return readAt(file_.get(), at, bytes, path_);
}

Status ScratchFile::sync() const {
    return syncPath(path_);
}

Result<FileDescriptor> openRegular(const PathBeneath& path) {
    // O_NONBLOCK: a named pipe in a file's place must not make the server wait.
    FileDescriptor file = path.open(O_RDONLY | O_NONBLOCK);
    if (!file.valid() && errno == ELOOP) {
        return Error{ErrorCode::corrupt, path.string(),
                     "is a link or lies behind one, where a dataset has files of its own"};
    }
    if (!file.valid()) return systemError(errno, path.string(), "cannot be opened");
    struct stat status {};
    if (::fstat(file.get(), &status) != 0) return systemError(errno, path.string(), "cannot be opened");
    if (!S_ISREG(status.st_mode)) return Error{ErrorCode::corrupt, path.string(), "is not a regular file"};
    return file;
}

Result<std::string> readWhole(const PathBeneath& path, std::size_t limit) {
    MOTE_ASSIGN_OR_RETURN(const auto file, openRegular(path));
    std::string text;
    while (true) {
        constexpr std::size_t piece = std::size_t{1} << 18;
        const std::size_t begin = text.size();
        text.resize(begin + piece);
        const ssize_t got = ::read(file.get(), text.data() + begin, piece);
        text.resize(begin + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return systemError(errno, path.string(), "cannot be read");
        if (got == 0) return text;
        if (text.size() > limit) {
            return Error{ErrorCode::resourceExhausted, path.string(),
                         fmt::format("is larger than the {} bytes that a file of its kind may have", limit)};
        }
    }
}

std::ptrdiff_t readPast(int descriptor, std::uint64_t offset, std::span<std::byte> bytes) {
    const iovec part{bytes.data(), std::min(bytes.size(), most)};
    const ssize_t got = ::preadv2(descriptor, &part, 1, static_cast<off_t>(offset), pastCache);
    if (got >= 0 || !isUnknown(errno)) return got;
    return ::pread(descriptor, part.iov_base, part.iov_len, static_cast<off_t>(offset));
}

Status writeAt(int descriptor, std::uint64_t offset, std::span<const std::byte> bytes,
               const std::filesystem::path& name, PageCache cache) {
    while (!bytes.empty()) {
        const ssize_t wrote = writeSome(descriptor, offset, bytes, cache);
        if (wrote < 0 && errno == EINTR) continue;
        if (wrote <= 0) return systemError(wrote < 0 ? errno : ENOSPC, name.string(), "cannot be written");
        bytes = bytes.subspan(static_cast<std::size_t>(wrote));
        offset += static_cast<std::uint64_t>(wrote);
    }
    return success();
}

Status readAt(int descriptor, std::uint64_t offset, std::span<std::byte> bytes,
              const std::filesystem::path& name, PageCache cache) {
    while (!bytes.empty()) {
        const ssize_t got =
            cache == PageCache::passed
                ? readPast(descriptor, offset, bytes)
                : ::pread(descriptor, bytes.data(), std::min(bytes.size(), most), static_cast<off_t>(offset));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return systemError(got < 0 ? errno : EIO, name.string(), "cannot be read again");
        bytes = bytes.subspan(static_cast<std::size_t>(got));
        offset += static_cast<std::uint64_t>(got);
    }
    return success();
}

Status writeNewFile(const std::filesystem::path& path, std::string_view text) {
    const FileDescriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (!file.valid()) return systemError(errno, path.string(), "cannot be made");
    Status status = writeAt(file.get(), 0, std::as_bytes(std::span(text)), path);
    if (status.ok() && ::fsync(file.get()) != 0) {
        status = systemError(errno, path.string(), "cannot be written to the disk");
    }
    if (!status.ok()) ::unlink(path.c_str());
    return status;
}

Status syncPath(const std::filesystem::path& path) {
    const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file.valid()) return systemError(errno, path.string(), "cannot be opened");
    // EINVAL: a file system that cannot sync folders has nothing to do.
    if (::fsync(file.get()) != 0 && errno != EINVAL) {
        return systemError(errno, path.string(), "cannot be written to the disk");
    }
    return success();
}

Status publishByRename(const std::filesystem::path& from, const std::filesystem::path& to) {
    const int number = renameNew(from, to);
    if (number == EEXIST || number == ENOTEMPTY) {
        return Error{ErrorCode::alreadyExists, to.string(), "exists already and is never replaced"};
    }
    if (number != 0) return systemError(number, to.string(), "cannot be put in place");
    auto synced = syncPath(folderOf(to));
    // Who is told of an error finds nothing, as after any other.
    if (!synced.ok()) static_cast<void>(renameNew(to, from));
    return synced;
}

}  // namespace mote::storage
