// SPDX-License-Identifier: GPL-3.0-or-later
//
// Comparison: how far one picture is from another, on average and at its worst. A value; pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "tests/support/image.h"

namespace mote::test {

/// What a device must reach against the reference.
struct Limits {
    double psnr = 45.0;         ///< dB, at least
    double closeShare = 0.999;  ///< of the pixels, at least, are close
    int worst = 12;             ///< of 255, at most, outside pixels in doubt
};

struct Comparison {
    static constexpr int close = 2;  ///< of 255, in each channel

    bool sameShape = false;    ///< same width and height, at least one pixel, as many bytes as that needs
    bool sameAlpha = false;    ///< in every pixel
    double psnr = 0.0;         ///< dB over red, green and blue, sRGB-encoded; infinite where all is equal
    double closeShare = 0.0;   ///< share of pixels that are close
    int worst = 255;           ///< the greatest difference in a channel, pixels in doubt left out
    std::uint32_t column = 0;  ///< of the worst pixel
    std::uint32_t row = 0;

    bool within(const Limits& limits) const;
    std::string toString() const;
};

/// `doubtful`: empty, or one a pixel, not zero where the worst difference is not taken from.
Comparison compare(const Image& actual, const Image& expected, std::span<const std::uint8_t> doubtful = {});

/// Differences, 16 times as large, white where they reach 16 of 255 in all channels; pictures of one shape.
Image difference(const Image& one, const Image& other);

/// Writes the picture, which a person should look at, as golden/NAME.png of the build, replaced; a failure is
/// a test failure.
void keep(const Image& image, const std::string& name);

/// Whether MOTE_GOLDEN_KEEP is set: every picture is then kept, not only those that fail.
bool keepAll();

}  // namespace mote::test
