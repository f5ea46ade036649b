// SPDX-License-Identifier: GPL-3.0-or-later
//
// MappingGuard: a mapping of a file whose pages may vanish. Who touches a page beyond the end of a file that
// was truncated meanwhile, or one that its disk cannot read, gets SIGBUS. In a process that called
// catchMappingFaults(), such a page of a guarded mapping becomes zeros instead, with all after it, and the
// guard knows: what was read since is worth nothing, and whoever reads asks fault() before it uses or shows
// what it made.
//
// A signal handler has no argument, so the guarded ranges stand in one table of the process, which the
// handler reads without locks. Move-only; fault() on any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "protocol/scene/error.h"

namespace mote::storage {

/// Once, by main, before the first mapping is read. SIGBUS at other addresses goes to the handler before
/// ours.
void catchMappingFaults();

class MappingGuard {
  public:
    static constexpr std::size_t most = 4096;  ///< guarded mappings of a process

    /// `bytes` is a whole mapping, from a page's begin, that outlives the guard; not empty. Errors:
    /// resourceExhausted.
    static Result<MappingGuard> make(std::span<const std::byte> bytes);

    MappingGuard() = default;
    MappingGuard(MappingGuard&& other) noexcept : slot_(std::exchange(other.slot_, none)) {}
    MappingGuard& operator=(MappingGuard&& other) noexcept {
        std::swap(slot_, other.slot_);
        return *this;
    }
    ~MappingGuard();

    /// The least offset, in bytes, of a page that was touched and could not be read; nothing as long as all
    /// is well.
    std::optional<std::uint64_t> fault() const;

  private:
    static constexpr std::size_t none = SIZE_MAX;

    explicit MappingGuard(std::size_t slot) : slot_(slot) {}

    std::size_t slot_ = none;
};

}  // namespace mote::storage
