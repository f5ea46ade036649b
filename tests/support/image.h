// SPDX-License-Identifier: GPL-3.0-or-later
//
// Image: 8-bit sRGB pixels as a test sees them, and PNG files of them, so that a failing picture can be
// looked at. A value.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "protocol/base/error.h"

namespace mote::test {

struct Image {
    std::uint32_t width = 0;           ///< pixels
    std::uint32_t height = 0;          ///< pixels
    std::vector<std::uint8_t> pixels;  ///< RGBA, row 0 on top

    bool operator==(const Image&) const = default;
};

/// Makes the folder where it is missing. Errors: internal, with libpng's own words.
Status writePng(const Image& image, const std::filesystem::path& path);

/// Errors: notFound, unsupported (not three or four channels of 8 bits).
Result<Image> readPng(const std::filesystem::path& path);

}  // namespace mote::test
