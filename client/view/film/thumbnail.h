// SPDX-License-Identifier: GPL-3.0-or-later
//
// Thumbnail: a picture made small: the middle of it that has the wanted proportions, averaged. A value; pure
// functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace mote::client {

struct Thumbnail {
    std::uint32_t width = 0;           ///< pixels
    std::uint32_t height = 0;          ///< pixels
    std::vector<std::uint8_t> pixels;  ///< RGBA, sRGB-encoded, row 0 on top
};

/// Of a picture of 4 * width * height bytes, RGBA, row 0 on top. Nothing of it is empty; one that is smaller
/// is made larger.
Thumbnail makeThumbnail(std::span<const std::uint8_t> picture, std::uint32_t width, std::uint32_t height,
                        std::uint32_t smallWidth, std::uint32_t smallHeight);

}  // namespace mote::client
