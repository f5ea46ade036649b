// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pictures of what a drawing is made from, to be looked at (figure 19 of the dissertation): linear RGB, 0 to
// 1. Pure.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "server/render/ink/modalities.h"
#include "server/render/ink/tone_grid.h"

namespace mote::render {

/// 0 is black, 1 white.
Raster<glm::vec3> greyPicture(const Raster<float>& values);
/// 0 is white paper, 1 black ink.
Raster<glm::vec3> paperPicture(const Raster<float>& cover);
/// The nearest is white, the farthest dark, nothing black.
Raster<glm::vec3> depthPicture(const Modalities& modalities);
/// A hue around the circle of directions, which have no sign; grey if there is none, black for nothing.
Raster<glm::vec3> anglePicture(const Modalities& modalities);
/// Each label a colour that means nothing; black above all labels.
Raster<glm::vec3> labelPicture(const Raster<std::uint32_t>& labels);
/// A grid in the size of its picture.
Raster<float> spread(const ToneGrid& grid, const ToneCells& cells, std::uint32_t width, std::uint32_t height);

}  // namespace mote::render
