// SPDX-License-Identifier: GPL-3.0-or-later
//
// PNG files of R, G and B, and opacity if it is wanted, in 8 or 16 bits, sRGB-encoded (ISO/IEC 15948), by
// libdeflate: two to three times faster than libpng, and about as small. The same pixels give the same bytes.
// Pure functions, any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"

namespace mote::client {

/// Where the samples of a picture lie: rows without padding, row 0 on top; of 16 bits the high byte first.
struct PngSamples {
    std::uint32_t width = 0;   ///< pixels
    std::uint32_t height = 0;  ///< pixels
    unsigned bits = 8;         ///< of a sample: 8 or 16
    unsigned channels = 4;     ///< 3; or 4, of which the last is left out
    std::span<const std::uint8_t> bytes;
    bool alpha = false;  ///< of 4 channels the last is kept, as opacity: colours are not premultiplied
};

/// The bytes of a file; `description` goes into it as the text of that name, unless it is empty. Samples of
/// at least one pixel, as many as the sizes say (our own invariant).
std::vector<std::uint8_t> encodePng(const PngSamples& samples, std::string_view description = {});

struct PngPicture {
    std::uint32_t width = 0;   ///< pixels
    std::uint32_t height = 0;  ///< pixels
    unsigned bits = 8;         ///< of a sample: 8 or 16
    std::string description;
    std::vector<std::uint8_t> bytes;  ///< as PngSamples, three channels
};

/// A file that is whole: every sum of its chunks and of its pixels agrees. Sizes are checked before memory is
/// taken. Errors: corrupt, unsupported (a PNG of another kind than encodePng() makes), both without a place.
Result<PngPicture> readPng(std::span<const std::uint8_t> file);

}  // namespace mote::client
