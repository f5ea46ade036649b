// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/blocks/mapping_guard.h"

#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <mutex>

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

}  // namespace mote::storage
