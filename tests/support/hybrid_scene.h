// SPDX-License-Identifier: GPL-3.0-or-later
//
// Hybrid volumes made in memory for tests: a field given as a function, its coarse grid, and
// corrections of it as residuals, which are exact, or as points. Pure functions.
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <memory>

#include "server/render/plan/grid_field.h"

namespace mote::test {

struct HybridShape {
    glm::uvec3 source{32};  ///< voxels; the error grid is the source's
    glm::uvec3 low{8};
    glm::dmat4 boxToLayer{1.0};
    ValueRange range{0.0, 1.0};
    double threshold = 0.0;  ///< errors above it become residuals and points, in the source's unit
    HybridRepresentation parts = HybridRepresentation::residual;
};

/// `field`: the value at a place in the box [0, 1]^3. The coarse grid's samples are the field's own.
std::shared_ptr<const render::GridField> hybridOf(const HybridShape& shape,
                                                  const std::function<double(const glm::dvec3&)>& field);

/// A shell, two balls and a thin rod in a smooth ground: what a low resolution gets wrong. Values 0 to 1.
double machineParts(const glm::dvec3& inBox);

}  // namespace mote::test
