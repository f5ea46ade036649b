// SPDX-License-Identifier: GPL-3.0-or-later
//
// From a picture's luminance to the density of dots that has its tones (docs/STIPPLES.md, "Tones"). Pure;
// uses all threads of the calling arena.
#pragma once

#include <cstdint>

#include "server/render/layers/stipple/pixel_map.h"

namespace mote::render {

struct PhotographTone {
    double spacing = 5.0;   ///< between dots where the tone is full, pixels
    double dot = 2.0;       ///< diameter of a dot, pixels
    double gamma = 1.0;     ///< luminance ^ gamma is the brightness
    bool denseDark = true;  ///< the tone is 1 - brightness; else brightness

    /// Dots a square pixel where the tone is full.
    double fullDensity() const;
};

/// Where a picture of an aspect lies in another: as large as fits, in the middle.
struct PictureFit {
    double left = 0.0, top = 0.0;  ///< pixels of the larger one
    double scale = 1.0;            ///< its pixels a pixel of the picture

    static PictureFit within(std::uint32_t width, std::uint32_t height, const PixelMap& picture);
};

/// The wanted dots a square pixel of a picture of width x height, none where `luminance` is not.
PixelMap wantedDensity(const PixelMap& luminance, std::uint32_t width, std::uint32_t height,
                       const PhotographTone& tone);

}  // namespace mote::render
