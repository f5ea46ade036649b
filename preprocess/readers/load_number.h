// SPDX-License-Identifier: GPL-3.0-or-later
//
// A number out of the bytes of a foreign file, whatever their order and wherever they lie. Pure.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace mote::prep {

static_assert(std::endian::native == std::endian::little,
              "numbers of files are turned into little-endian ones");

/// Reads sizeof(Number) bytes.
template <class Number>
Number loadNumber(const char* from, bool bigEndian) {
    std::array<char, sizeof(Number)> bytes;
    std::memcpy(bytes.data(), from, sizeof(Number));
    if (bigEndian) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<Number>(bytes);
}

}  // namespace mote::prep
