// SPDX-License-Identifier: GPL-3.0-or-later
//
// Luminance: a grey picture, the linear luminance of each pixel. A value.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mote::storage {

struct Luminance {
    std::uint32_t width = 0;    ///< pixels
    std::uint32_t height = 0;   ///< pixels
    std::vector<float> values;  ///< 0 black, 1 white, above 1 in pictures of high range; rows from the top

    float at(std::size_t x, std::size_t y) const { return values[y * width + x]; }
    bool operator==(const Luminance&) const = default;
};

}  // namespace mote::storage
