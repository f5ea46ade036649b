// SPDX-License-Identifier: GPL-3.0-or-later
//
// Memory that is kept for when there is none. Where operator new finds none, the reserve is given back to the
// kernel and it tries once more: what takes little, such as the words for an error or the next step of a
// coroutine, goes well (Asio ends the process where that finds no memory), and what takes much fails. Of the
// process; any thread.
#pragma once

#include <cstddef>

namespace mote::server {

inline constexpr std::size_t memoryReserve = std::size_t{8} << 20;  ///< bytes

/// Keeps it from now on, or again where it was given back. Whether it is kept: there may be no memory for it
/// now.
bool keepMemoryReserve() noexcept;

}  // namespace mote::server
