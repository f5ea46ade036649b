// SPDX-License-Identifier: GPL-3.0-or-later
//
// These functions find an octree cell's integer place from its Morton code. They are pure.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

namespace mote::storage {

/// Deeper than this a Morton code of 64 bits cannot tell cells apart.
inline constexpr std::uint8_t deepestLevel = 21;

/// Every third bit of a Morton code, closed up.
inline std::uint32_t everyThirdBit(std::uint64_t code) {
    code &= 0x1249249249249249ULL;
    code = (code | (code >> 2)) & 0x10c30c30c30c30c3ULL;
    code = (code | (code >> 4)) & 0x100f00f00f00f00fULL;
    code = (code | (code >> 8)) & 0x001f0000ff0000ffULL;
    code = (code | (code >> 16)) & 0x001f00000000ffffULL;
    code = (code | (code >> 32)) & 0x00000000001fffffULL;
    return static_cast<std::uint32_t>(code);
}

/// Column, row and slice of a cell among the cells of its level.
inline glm::uvec3 cellPlace(std::uint64_t morton) {
    return {everyThirdBit(morton), everyThirdBit(morton >> 1), everyThirdBit(morton >> 2)};
}

}  // namespace mote::storage
