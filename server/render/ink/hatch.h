// SPDX-License-Identifier: GPL-3.0-or-later
//
// Hatching (the dissertation's section 2.3.6): each region of a picture is filled with straight strokes of
// one direction, then with strokes across, then along both diagonals, until its tone is met. Pure.
#pragma once

#include <glm/vec2.hpp>
#include <stop_token>
#include <vector>

#include "server/render/ink/raster.h"

namespace mote::render {

struct HatchOptions {
    double spacing = 4.0;   ///< between the strokes of a layer, pixels
    double width = 1.0;     ///< of a stroke, pixels
    double shortest = 2.0;  ///< of a stroke, pixels
};

/// How the strokes of a region's first layer lie: those of others are turned around the same place.
struct HatchAxes {
    double direction = 0.0;  ///< radians
    glm::dvec2 origin{0.0};  ///< through which one would pass; pixels
};

/// A straight stroke; pixels.
struct HatchStroke {
    glm::dvec2 from, to;
};

/// Regions and what is wanted in them.
struct HatchRegions {
    const Raster<std::uint32_t>& label;  ///< below `count`; others are not hatched
    std::uint32_t count;
    const Raster<float>& angle;    ///< of the first layer's strokes, radians; the mean of a region counts
    const Raster<float>& density;  ///< of ink that is wanted (tone_grid.h)
};

/// Along the mean direction of each region, on one raster of the whole picture for each direction, so what
/// changes in one region leaves the others alone.
std::vector<HatchAxes> hatchAxes(const HatchRegions& regions);

/// Region by region, layer by layer. `axes`: of the regions.
std::vector<HatchStroke> hatch(const HatchRegions& regions, const std::vector<HatchAxes>& axes,
                               const HatchOptions& options, const std::stop_token& stop);

/// The density that all layers have together.
double mostHatched(const HatchOptions& options);

}  // namespace mote::render
