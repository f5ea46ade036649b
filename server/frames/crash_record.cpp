// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/crash_record.h"

#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <new>
#include <system_error>

#include "protocol/wire/framing.h"

namespace mote::server {
namespace {

/// The views that are remembered: each has ended a server, so that there are few.
constexpr std::size_t mostViews = 256;

}  // namespace

/// A view's bytes are there when its size is. No message of a client is longer.
struct CrashRecord::Shared {
    std::atomic<bool> ready = false;
    std::atomic<bool> shortOfMemory = false;
    std::atomic<bool> measured = false;
    render::DeviceCosts costs;  // where `measured`
    std::atomic<std::uint32_t> size = 0;
    std::array<char, wire::clientLimits.message> bytes;  // pages that nobody writes take no memory
};

CrashRecord::CrashRecord() {
    void* const memory =
        ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::system_error(errno, std::generic_category(), "shared memory");
    shared_ = new (memory) Shared;
}

CrashRecord::~CrashRecord() {
    ::munmap(shared_, sizeof(Shared));
}

void CrashRecord::ready() {
    shared_->ready = true;
}

void CrashRecord::shortOfMemory() noexcept {
    shared_->shortOfMemory = true;
}

void CrashRecord::begin(std::string_view view) {
    shared_->size = 0;
    const std::size_t size = std::min(view.size(), shared_->bytes.size());
    std::copy_n(view.begin(), size, shared_->bytes.begin());
    shared_->size = static_cast<std::uint32_t>(size);
}

void CrashRecord::end() {
    shared_->size = 0;
}

void CrashRecord::learn(const render::DeviceCosts& costs) {
    shared_->costs = costs;
    shared_->measured = true;
}

std::optional<render::DeviceCosts> CrashRecord::costs() const {
    if (!shared_->measured) return std::nullopt;
    return shared_->costs;
}

unsigned CrashRecord::deaths(std::string_view view) const {
    const auto found = deaths_.find(view);
    return found == deaths_.end() ? 0 : found->second;
}

void CrashRecord::clear() {
    shared_->ready = false;
    shared_->shortOfMemory = false;
    shared_->size = 0;
}

bool CrashRecord::wasReady() const {
    return shared_->ready;
}

bool CrashRecord::wasShortOfMemory() const {
    return shared_->shortOfMemory;
}

std::optional<std::string> CrashRecord::view() const {
    const std::size_t size = std::min<std::size_t>(shared_->size, shared_->bytes.size());
    if (size == 0) return std::nullopt;
    return std::string(shared_->bytes.data(), size);
}

unsigned CrashRecord::count(const std::string& view) {
    if (deaths_.size() >= mostViews && deaths_.count(view) == 0) deaths_.erase(deaths_.begin());
    return ++deaths_[view];
}

}  // namespace mote::server
