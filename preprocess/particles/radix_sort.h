// SPDX-License-Identifier: GPL-3.0-or-later
//
// A stable parallel sort of 64-bit keys that carry 32-bit indices: least significant digit first, so the
// result is the same for any number of threads. Pure.
#pragma once

#include <cstdint>
#include <vector>

namespace mote::prep {

struct KeyedIndices {
    std::vector<std::uint64_t> key;
    std::vector<std::uint32_t> index;  ///< as many
};

/// Ascending by the low `bits` bits of the keys (the others are zero), equal keys in their old order. Needs
/// as much memory again while it works. Uses all threads of the calling arena.
void radixSort(KeyedIndices& items, unsigned bits);

}  // namespace mote::prep
