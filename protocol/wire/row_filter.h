// SPDX-License-Identifier: GPL-3.0-or-later
//
// The row filter of lossless frames: pixels become differences to their left neighbour, which zstd packs far
// better than the pixels. Alpha is 1 everywhere and left out. Pure functions, any thread.
//
// SRGB8: R, G, B of each pixel, each a byte less the one of the pixel to the left (0 before the first),
// modulo 256. LINEAR_HALF: the bits of R, G, B as u16, less those of the pixel to the left, modulo 65536; in
// each row first all low bytes, then all high bytes, as these two hardly resemble each other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "protocol/mote.pb.h"

namespace mote::wire {

/// The bytes of one pixel with its alpha: 4 (SRGB8), 8 (LINEAR_HALF) or 0 (a format that we do not know).
std::size_t pixelSize(proto::PixelFormat format);

/// The bytes of one pixel once filtered: 3, 6 or 0.
std::size_t filteredPixelSize(proto::PixelFormat format);

/// RGBA rows without padding into filtered ones. `rgba` holds pixelSize() and `filtered`
/// filteredPixelSize() bytes a pixel, exactly; the format is known (our own invariants).
void filterRows(proto::PixelFormat format, std::uint32_t width, std::span<const std::uint8_t> rgba,
                std::span<std::uint8_t> filtered);

/// The way back; alpha becomes 1.
void unfilterRows(proto::PixelFormat format, std::uint32_t width, std::span<const std::uint8_t> filtered,
                  std::span<std::uint8_t> rgba);

}  // namespace mote::wire
