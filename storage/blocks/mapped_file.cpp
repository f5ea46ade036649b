// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/blocks/mapped_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>

#include <cerrno>
#include <vector>

#include "protocol/scene/system_error.h"
#include "storage/files/packed_file.h"
#include "storage/files/read_file.h"
#include "storage/files/write_file.h"

namespace mote::storage {
namespace {

constexpr std::streamsize unpackedPiece = std::streamsize{1} << 20;  // bytes
constexpr std::uint64_t pageBytes = 4096;  // a wish for less than the kernel's page is refused, and no harm

bool same(const timespec& a, const timespec& b) {
    return a.tv_sec == b.tv_sec && a.tv_nsec == b.tv_nsec;
}

}  // namespace

Result<MappedFile> MappedFile::open(const std::filesystem::path& path, std::uint64_t expectedSize) {
    MOTE_ASSIGN_OR_RETURN(auto file, openRegular(path));
    struct stat status {};
    if (::fstat(file.get(), &status) != 0) return systemError(errno, path.string(), "cannot be opened");
    const auto size = static_cast<std::uint64_t>(status.st_size);
    if (size != expectedSize) {
        return Error{ErrorCode::corrupt, path.string(),
                     fmt::format("has {} bytes where the manifest says {}: it is truncated or was changed",
                                 size, expectedSize)};
    }
    MappedFile mapped(path.string(), std::move(file));
    mapped.changed_ = status.st_mtim;
    MOTE_RETURN_IF_ERROR(mapped.map(size));
    return mapped;
}

Result<MappedFile> MappedFile::unpack(const std::filesystem::path& path, std::uint64_t most) {
    MOTE_ASSIGN_OR_RETURN(auto source, PackedSource::open(path));
    MappedFile memory(path.string(), FileDescriptor(::memfd_create("mote-unpacked", MFD_CLOEXEC)));
    if (!memory.file_.valid()) return systemError(errno, path.string(), "cannot be unpacked");
    std::vector<char> piece(unpackedPiece);
    std::uint64_t size = 0;
    for (auto got = source->sgetn(piece.data(), unpackedPiece); got > 0;
         got = source->sgetn(piece.data(), unpackedPiece)) {
        const std::span some(piece.data(), static_cast<std::size_t>(got));
        if (some.size() > most - size) {
            return Error{ErrorCode::corrupt, path.string(), fmt::format("holds more than {} bytes", most)};
        }
        MOTE_RETURN_IF_ERROR(writeAt(memory.file_.get(), size, std::as_bytes(some), path));
        size += some.size();
    }
    struct stat status {};
    if (::fstat(memory.file_.get(), &status) != 0)
        return systemError(errno, path.string(), "cannot be unpacked");
    memory.changed_ = status.st_mtim;
    MOTE_RETURN_IF_ERROR(memory.map(size));
    return memory;
}

Status MappedFile::map(std::uint64_t size) {
    if (size == 0) return success();
    void* address = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file_.get(), 0);
    if (address == MAP_FAILED) return systemError(errno, path_, "cannot be mapped");
    bytes_ = {static_cast<const std::byte*>(address), size};
    auto guard = MappingGuard::make(bytes_);
    if (!guard.ok()) return guard.error().within(path_);
    guard_ = *std::move(guard);
    return success();
}

MappedFile::~MappedFile() {
    guard_ = {};  // before the place may become another mapping's
    if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

std::optional<Error> MappedFile::damage() const {
    if (const auto offset = guard_.fault()) {
        return Error{ErrorCode::corrupt, path_,
                     fmt::format("cannot be read at byte {} any more: it was truncated while in use, or its "
                                 "disk fails; copy or make it again",
                                 *offset)};
    }
    struct stat status {};
    if (::fstat(file_.get(), &status) != 0) return systemError(errno, path_, "is out of reach");
    const auto size = static_cast<std::uint64_t>(status.st_size);
    if (size < bytes_.size()) {
        return Error{ErrorCode::corrupt, path_,
                     fmt::format("was truncated while in use: it ends at byte {} where it had {}; copy or "
                                 "make it again",
                                 size, bytes_.size())};
    }
    if (same(status.st_mtim, changed_)) return std::nullopt;
    return Error{ErrorCode::corrupt, path_, "was written to while in use; what was read of it is void"};
}

void MappedFile::expect(std::uint64_t begin, std::uint64_t size) const {
    ::posix_fadvise(file_.get(), static_cast<off_t>(begin), static_cast<off_t>(size), POSIX_FADV_WILLNEED);
}

void MappedFile::populate(std::uint64_t begin, std::uint64_t size) const {
    // Kernels before 5.14 do not know it: the pages come in one by one then.
    advise(begin / pageBytes * pageBytes, (begin + size + pageBytes - 1) / pageBytes * pageBytes,
           MADV_POPULATE_READ);
}

void MappedFile::giveUp(std::uint64_t begin, std::uint64_t size) const {
    advise((begin + pageBytes - 1) / pageBytes * pageBytes, (begin + size) / pageBytes * pageBytes,
           MADV_DONTNEED);
}

void MappedFile::advise(std::uint64_t first, std::uint64_t last, int advice) const {
    if (first >= last) return;
    ::madvise(const_cast<std::byte*>(bytes_.data()) + first, last - first, advice);
}

}  // namespace mote::storage
