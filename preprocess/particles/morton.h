// SPDX-License-Identifier: GPL-3.0-or-later
//
// Morton keys: the bits of three cell indices in turn, x in bit 0, y in bit 1, z in bit 2. Pure functions.
#pragma once

#include <array>
#include <cstdint>

namespace mote::prep {

/// The low 21 bits of `v`, two zeros behind each.
constexpr std::uint64_t spreadBits(std::uint64_t v) {
    v &= 0x1fffff;
    v = (v | v << 32) & 0x1f00000000ffff;
    v = (v | v << 16) & 0x1f0000ff0000ff;
    v = (v | v << 8) & 0x100f00f00f00f00f;
    v = (v | v << 4) & 0x10c30c30c30c30c3;
    v = (v | v << 2) & 0x1249249249249249;
    return v;
}

/// Undoes spreadBits.
inline std::uint32_t gatherBits(std::uint64_t v) {
    v &= 0x1249249249249249;
    v = (v | v >> 2) & 0x10c30c30c30c30c3;
    v = (v | v >> 4) & 0x100f00f00f00f00f;
    v = (v | v >> 8) & 0x1f0000ff0000ff;
    v = (v | v >> 16) & 0x1f00000000ffff;
    v = (v | v >> 32) & 0x1fffff;
    return static_cast<std::uint32_t>(v);
}

inline std::uint64_t mortonKey(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return spreadBits(x) | spreadBits(y) << 1 | spreadBits(z) << 2;
}

inline std::array<std::uint32_t, 3> mortonCell(std::uint64_t key) {
    return {gatherBits(key), gatherBits(key >> 1), gatherBits(key >> 2)};
}

}  // namespace mote::prep
