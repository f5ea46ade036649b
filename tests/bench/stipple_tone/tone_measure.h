// SPDX-License-Identifier: GPL-3.0-or-later
//
// How well dots show a tone: their drawing and the wanted ink, blurred alike, compared (docs/STIPPLES.md).
// Pure functions.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <string>
#include <vector>

#include "server/render/layers/stipple/pixel_map.h"

namespace mote::bench {

/// A number for each pixel, rows from the top.
struct Grid {
    std::uint32_t width = 0, height = 0;
    std::vector<float> values;
};

/// The ink of dots of a diameter in pixels, 0 to 1, antialiased; where dots meet, ink does not add up.
Grid drawDots(std::uint32_t width, std::uint32_t height, std::span<const glm::vec2> dots, double diameter);

/// The wanted ink of dots that do not overlap: their density times their area, at most 1.
Grid wantedInk(const render::PixelMap& density, double diameter);

/// With a Gaussian, whose part beyond the edges is left out.
Grid blurred(const Grid& grid, double sigma);

/// As a PNG of black ink on white paper, sRGB; false where it cannot be written.
bool writeInk(const Grid& ink, const std::string& path);

/// dB, of a peak of 1, after a blur of both.
double psnr(const Grid& a, const Grid& b, double sigma);

}  // namespace mote::bench
