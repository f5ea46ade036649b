// SPDX-License-Identifier: GPL-3.0-or-later
//
// The colours of films: sRGB-encoded R, G, B as luma and chroma of BT.709 in video range (16 to 235 and 16
// to 240). Code values are kept, as players expect: no change of the transfer function. protocol/wire/ycc.h
// does the same for the wire, in full range and 16 bits; here each sample is the nearest one, so that flat
// colours come back within 2 of 255. Pure functions, any thread.
//
// Y = 0.2126 R + 0.7152 G + 0.0722 B, Cb = (B - Y) / 1.8556, Cr = (R - Y) / 1.5748.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "client/frames/video/video_settings.h"

namespace mote::client {

/// Planes of Y, Cb and Cr that somebody else owns; rows may be padded, row 0 on top.
struct VideoPlanes {
    std::array<std::uint8_t*, 3> plane{};
    std::array<std::ptrdiff_t, 3> stride{};  ///< bytes from a row to the next

    std::uint8_t* row(std::size_t which, std::size_t y) const {
        return plane[which] + static_cast<std::ptrdiff_t>(y) * stride[which];
    }
};

/// RGBA rows without padding; alpha is left out. Halved: sides are even; chroma lies at the left column of
/// its two, between its two rows, which is where players look for it.
void rgbaToVideo(std::uint32_t width, std::span<const std::uint8_t> rgba, VideoChroma chroma,
                 const VideoPlanes& planes);

}  // namespace mote::client
