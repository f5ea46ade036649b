// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointSplat: a point of a hybrid volume on the screen (docs/PICTURE.md, "Hybrid volumes"). A value.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "protocol/scene/view.h"
#include "server/render/hybrid/hybrid_step.h"

namespace mote::reference {

struct PointSplat {
    double x, y;       ///< pixels
    double depth;      ///< world units along the line of sight
    double spacing;    ///< of the points on the screen there, pixels
    double size;       ///< w of PICTURE.md, pixels
    double opacity;    ///< before coverage
    glm::dvec3 color;  ///< linear RGB, with its light
    PointShape shape;

    /// Of a pixel whose centre lies at (dx, dy) from the point.
    double coverage(double dx, double dy) const;
    /// Beyond which nothing is covered; of a square, its edge.
    double reach() const;
};

/// In the dataset's order; empty where the layer draws no points.
std::vector<PointSplat> pointSplats(const render::HybridStep& step, const Layer& layer, const View& view);

}  // namespace mote::reference
