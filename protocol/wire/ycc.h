// SPDX-License-Identifier: GPL-3.0-or-later
//
// The colour space of H.264 frames: sRGB-encoded R, G, B as luma and chroma of BT.709, full range; one chroma
// sample for two by two pixels (4:2:0). Measured on points of one colour, that is 0.4 dB better than 4:4:4 at
// the rates where H.264 is chosen at all, for half the samples. Pure functions, any thread.
//
// Y = 0.2126 R + 0.7152 G + 0.0722 B, Cb = (B - Y) / 1.8556 + 128, Cr = (R - Y) / 1.5748 + 128.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace mote::wire {

/// Y, Cb and Cr of a picture that somebody else owns; rows may be padded. Luma has a sample a pixel, chroma
/// one for two columns and two rows, the last of an odd number alone. Byte is const where they are read.
template <class Byte>
struct YccPicture {
    std::array<Byte*, 3> plane{};            ///< row 0 on top
    std::array<std::ptrdiff_t, 3> stride{};  ///< bytes from a row to the next

    Byte* row(std::size_t which, std::size_t y) const {
        return plane[which] + static_cast<std::ptrdiff_t>(y) * stride[which];
    }
};

/// RGBA rows without padding; alpha is left out.
void rgbaToYcc(std::uint32_t width, std::span<const std::uint8_t> rgba, const YccPicture<std::uint8_t>& ycc);

/// The way back; alpha becomes 255. Within 2 of 255 of what it was where chroma is even and nothing was lost.
void yccToRgba(std::uint32_t width, const YccPicture<const std::uint8_t>& ycc, std::span<std::uint8_t> rgba);

}  // namespace mote::wire
