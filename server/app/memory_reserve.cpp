// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/memory_reserve.h"

#include <sys/mman.h>

#include <atomic>
#include <new>

namespace mote::server {
namespace {

std::atomic<void*> kept{nullptr};

/// malloc might keep for itself what it is given back: these are pages of our own.
void giveBack() {
    void* const pages = kept.exchange(nullptr);
    if (pages == nullptr) throw std::bad_alloc();
    ::munmap(pages, memoryReserve);
}

}  // namespace

bool keepMemoryReserve() noexcept {
    std::set_new_handler(giveBack);
    if (kept != nullptr) return true;
    void* const pages =
        ::mmap(nullptr, memoryReserve, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED) return false;
    void* none = nullptr;
    if (!kept.compare_exchange_strong(none, pages)) ::munmap(pages, memoryReserve);  // another thread did
    return true;
}

}  // namespace mote::server
