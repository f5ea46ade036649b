// SPDX-License-Identifier: GPL-3.0-or-later
//
// How dots make tones (docs/STIPPLES.md, "Tones"). Ink is the share of the paper that dots cover. Dots of
// diameter d at a density of rho would cover phi = rho pi d^2 / 4 if none met another; from where they begin
// to, they cover less. Pure functions.
#pragma once

#include <cstdint>

#include "server/render/layers/stipple/pixel_map.h"

namespace mote::render {

/// How a photograph's luminance becomes a density of dots.
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

/// The wanted dots a square pixel of a picture of width x height, none if `luminance` is not.
PixelMap wantedDensity(const PixelMap& luminance, std::uint32_t width, std::uint32_t height,
                       const PhotographTone& tone);

/// phi at which an even distribution covers everything: its largest cells fit into a dot.
inline constexpr double solidCover = 1.8;

/// Ink of dots at a nominal cover phi, 0 to 1, never falling.
double inkOfCover(double phi);
/// The nominal cover that gives an ink of 0 to 1: the inverse; solidCover for 1.
double coverOfInk(double ink);

/// Dots a square pixel of a diameter of `dot` pixels that give an ink.
double densityOfInk(double ink, double dot);

/// The density of points `spacing` pixels apart in the densest even arrangement, the hexagonal one: a square
/// pixel's share of 2 / (sqrt(3) spacing^2).
double densityOfSpacing(double spacing);

}  // namespace mote::render
