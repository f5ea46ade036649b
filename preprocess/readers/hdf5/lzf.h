// SPDX-License-Identifier: GPL-3.0-or-later
//
// Data that h5py's filter "lzf" has compressed (Lehmann's LZF): runs of bytes as they are, and copies of what
// stands up to 8 KiB before. A function without state.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace mote::prep {

/// How many bytes come out of one at most: a copy of 264 takes three.
inline constexpr std::uint64_t lzfRatio = 88;

/// Whether all of `packed` was undone into `bytes`, at most `most` of them; false where it is damaged.
bool undoLzf(std::span<const std::uint8_t> packed, std::size_t most, std::vector<std::uint8_t>& bytes);

}  // namespace mote::prep
