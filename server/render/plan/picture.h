// SPDX-License-Identifier: GPL-3.0-or-later
//
// A Picture is finished pixels, row 0 on top, RGBA. A value.
#pragma once

#include <cstdint>
#include <vector>

namespace mote::render {

enum class PixelFormat {
    srgb8,       ///< 4 bytes a pixel, sRGB-encoded
    linearHalf,  ///< 8 bytes a pixel, IEEE half floats, linear
};

struct Picture {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    PixelFormat format = PixelFormat::srgb8;
    std::vector<std::uint8_t> pixels;  ///< alpha is 1
    /// Of the leaves, or groups of them, of which something may be in view: no fewer than there are in it,
    /// and no more than the plan has.
    std::uint64_t pointsDrawn = 0;
};

inline std::uint32_t bytesPerPixel(PixelFormat format) {
    return format == PixelFormat::srgb8 ? 4 : 8;
}

}  // namespace mote::render
