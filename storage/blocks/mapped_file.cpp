// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/blocks/mapped_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <mutex>
#include <vector>

#include "protocol/base/system_error.h"
#include "storage/files/dataset_file.h"
#include "storage/files/packed_file.h"

namespace mote::storage {
namespace {

constexpr std::uint64_t unharmed = UINT64_MAX;

/// One guarded mapping. Its owner changes it while nobody reads the mapping, so a handler that is there for
/// that mapping sees it at rest; one that is there for another may see a change half done, and tells it by
/// the version, odd meanwhile.
struct Slot {
    std::atomic<bool> taken{false};
    std::atomic<std::uint32_t> version{0};
    std::atomic<std::uintptr_t> begin{0};
    std::atomic<std::uintptr_t> end{0};  ///< of the last page
    std::atomic<std::uint64_t> fault{unharmed};

    void set(std::uintptr_t first, std::uintptr_t last) {
        version.fetch_add(1);
        begin.store(first);
        end.store(last);
        fault.store(unharmed);
        version.fetch_add(1);
    }

    bool holds(std::uintptr_t address) const {
        const auto before = version.load();
        const bool within = begin.load() <= address && address < end.load();
        return within && before % 2 == 0 && version.load() == before;
    }
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free, "a signal handler may use it");

// The one table, and the handler before ours: see the header.
std::array<Slot, MappingGuard::most> slots;
struct sigaction previous {};

std::uintptr_t pageBytes() {
    static const auto size = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
    return size;
}

/// Zeros from the page of `address` to the mapping's end: what follows is gone as well, and would fault page
/// by page. The bare system call: a sanitizer's own mmap is not made for handlers.
bool becomeZeros(Slot& slot, std::uintptr_t address) {
    const std::uintptr_t begin = slot.begin.load();
    const std::uintptr_t page = address & ~(pageBytes() - 1);
    std::uint64_t known = slot.fault.load();
    while (page - begin < known && !slot.fault.compare_exchange_weak(known, page - begin)) {
    }
    return ::syscall(SYS_mmap, page, slot.end.load() - page, PROT_READ,
                     MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_FIXED, -1, 0) >= 0;
}

void passOn(int number, siginfo_t* info, void* context) {
    if ((previous.sa_flags & SA_SIGINFO) != 0) return previous.sa_sigaction(number, info, context);
    if (previous.sa_handler != SIG_DFL && previous.sa_handler != SIG_IGN) return previous.sa_handler(number);
    // Back to the instruction that faults, or to the sender's signal sent again: it ends the process.
    ::signal(number, SIG_DFL);
    if (info->si_code <= 0) ::raise(number);
}

void onBusError(int number, siginfo_t* info, void* context) {
    const int before = errno;
    const auto address = reinterpret_cast<std::uintptr_t>(info->si_addr);
    // A code that is not positive: somebody sent the signal, and there is no address.
    if (info->si_code > 0) {
        for (auto& slot : slots) {
            if (!slot.holds(address)) continue;
            const bool zeros = becomeZeros(slot, address);
            errno = before;
            if (zeros) return;
            break;
        }
    }
    passOn(number, info, context);
    errno = before;
}

constexpr std::streamsize unpackedPiece = std::streamsize{1} << 20;  // bytes
constexpr std::uint64_t adviceBytes = 4096;  // a wish for less than the kernel's page is refused, and no harm

bool same(const timespec& a, const timespec& b) {
    return a.tv_sec == b.tv_sec && a.tv_nsec == b.tv_nsec;
}

}  // namespace

void catchMappingFaults() {
    static std::once_flag once;
    std::call_once(once, [] {
        pageBytes();  // asked for here, as a handler may not initialise anything
        struct sigaction action {};
        action.sa_sigaction = onBusError;
        action.sa_flags = SA_SIGINFO | SA_ONSTACK;
        ::sigemptyset(&action.sa_mask);
        ::sigaction(SIGBUS, &action, &previous);
    });
}

Result<MappingGuard> MappingGuard::make(std::span<const std::byte> bytes) {
    const auto begin = reinterpret_cast<std::uintptr_t>(bytes.data());
    const std::uintptr_t pages = (bytes.size() + pageBytes() - 1) / pageBytes();
    for (std::size_t i = 0; i < slots.size(); ++i) {
        if (slots[i].taken.exchange(true)) continue;
        slots[i].set(begin, begin + pages * pageBytes());
        return MappingGuard(i);
    }
    return Error{ErrorCode::resourceExhausted, "", "too many files are mapped at once"};
}

MappingGuard::~MappingGuard() {
    if (slot_ == none) return;
    slots[slot_].set(0, 0);
    slots[slot_].taken.store(false);
}

std::optional<std::uint64_t> MappingGuard::fault() const {
    if (slot_ == none) return std::nullopt;
    const auto offset = slots[slot_].fault.load(std::memory_order_relaxed);
    return offset == unharmed ? std::nullopt : std::optional(offset);
}

Result<MappedFile> MappedFile::open(const PathBeneath& path, std::uint64_t expectedSize) {
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
    mapped.written_ = status.st_mtim;
    mapped.changed_ = status.st_ctim;
    MOTE_RETURN_IF_ERROR(mapped.map(size));
    return mapped;
}

Result<MappedFile> MappedFile::unpack(const PathBeneath& path, std::uint64_t most) {
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
        MOTE_RETURN_IF_ERROR(writeAt(memory.file_.get(), size, std::as_bytes(some), path.path()));
        size += some.size();
    }
    struct stat status {};
    if (::fstat(memory.file_.get(), &status) != 0)
        return systemError(errno, path.string(), "cannot be unpacked");
    memory.written_ = status.st_mtim;
    memory.changed_ = status.st_ctim;
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
    if (same(status.st_mtim, written_) && same(status.st_ctim, changed_)) return std::nullopt;
    return Error{ErrorCode::corrupt, path_, "was written to while in use; what was read of it is void"};
}

void MappedFile::expect(std::uint64_t begin, std::uint64_t size) const {
    ::posix_fadvise(file_.get(), static_cast<off_t>(begin), static_cast<off_t>(size), POSIX_FADV_WILLNEED);
}

void MappedFile::populate(std::uint64_t begin, std::uint64_t size) const {
    // Kernels before 5.14 do not know it: the pages come in one by one then.
    advise(begin / adviceBytes * adviceBytes, (begin + size + adviceBytes - 1) / adviceBytes * adviceBytes,
           MADV_POPULATE_READ);
}

void MappedFile::giveUp(std::uint64_t begin, std::uint64_t size) const {
    advise((begin + adviceBytes - 1) / adviceBytes * adviceBytes, (begin + size) / adviceBytes * adviceBytes,
           MADV_DONTNEED);
}

void MappedFile::advise(std::uint64_t first, std::uint64_t last, int advice) const {
    if (first >= last) return;
    ::madvise(const_cast<std::byte*>(bytes_.data()) + first, last - first, advice);
}

}  // namespace mote::storage
