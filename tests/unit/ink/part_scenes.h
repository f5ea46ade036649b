// SPDX-License-Identifier: GPL-3.0-or-later
//
// Scenes whose parts are known: boxes, balls, cylinders, cones and rings on a ground, ray cast without any
// mesh, and how near boundaries that are found are to those between parts. The control of regions. Pure.
#pragma once

#include <cstdint>

#include "server/render/ink/modalities.h"
#include "tests/support/random.h"

namespace mote::test {

/// What surfaces are like.
enum class Relief {
    smooth,
    rough  ///< normals of half of the parts lean by a pattern of waves, checks or noise
};

struct PartScene {
    render::Modalities modalities;  ///< all of part 0: where parts end is to be found
    render::Raster<std::uint32_t>
        part;  ///< the smooth piece of a solid that is seen: a box has six, a ball one
};

/// A picture of solids in any place and attitude, white, in the light that an ink style has by default; four
/// places a pixel.
PartScene partScene(Random& random, std::uint32_t width, std::uint32_t height, Relief relief);

/// How much of boundaries has its like nearby, 0 to 1.
struct BoundaryMeasure {
    double precision = 0.0;  ///< share of the boundary found that lies at one wanted
    double recall = 0.0;     ///< share of the boundary wanted that lies at one found

    double f() const {
        return precision + recall > 0.0 ? 2.0 * precision * recall / (precision + recall) : 0.0;
    }
};

/// Boundaries between labels, but for UINT32_MAX, where nothing is seen; `near`: pixels apart, at most.
BoundaryMeasure compareBoundaries(const render::Raster<std::uint32_t>& found,
                                  const render::Raster<std::uint32_t>& wanted, double near);

}  // namespace mote::test
