// SPDX-License-Identifier: GPL-3.0-or-later
//
// FramePixels: the pixels of a decoded frame, RGBA, row 0 on top, without padding. A value.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/mote.pb.h"

namespace mote::client {

struct FramePixels {
    std::uint32_t width = 0;   ///< pixels
    std::uint32_t height = 0;  ///< pixels
    /// PIXEL_FORMAT_UNSPECIFIED: no pixels, but the bytes of a document.
    /// SRGB8: 4 bytes a pixel, sRGB-encoded; LINEAR_HALF: four little-endian IEEE halves a pixel, linear.
    proto::PixelFormat format = proto::SRGB8;
    std::vector<std::uint8_t> bytes;
};

}  // namespace mote::client
