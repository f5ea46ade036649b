// SPDX-License-Identifier: GPL-3.0-or-later
//
// TransferFunction: what a scalar field shows at each of its values: how much it absorbs, and its colour.
// Particle plots (t, the scaled log density of log_density.h) and hybrid volumes (the source's unit) are
// drawn by it alike. Source: sections 3.2.2 and 3.3.3 of the dissertation. A value; safe on any number of
// threads.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "protocol/scene/color_map.h"
#include "protocol/scene/curve.h"

namespace mote {

struct ValueRange {
    double low, high;  ///< in the unit of the values; low < high

    bool operator==(const ValueRange&) const = default;
};

struct TransferFunction {
    /// Opacities are held below one, so that extinction stays finite; what is left is invisible in 8 bits.
    static constexpr double opacityLimit = 0.9999;

    Curve opacity;         ///< value -> opacity over opacityLength
    double opacityLength;  ///< layer units
    /// Below 0 the extinction falls linearly to none at so far; 0: it does not.
    double fade = 0.0;
    ColorMap colorMap = ColorMap::standard();
    ValueRange colorRange{0.0, 1.0};  ///< of the colour map
    /// Linear RGB, one a knot of the curve, in place of the colour map; or empty.
    std::vector<glm::dvec3> colors = {};
    ValueRange span{0.0, 1.0};  ///< outside of which neither changes

    /// The extinction per unit length of layer space.
    double extinction(double value) const;
    /// Linear RGB, before light.
    glm::dvec3 color(double value) const;
    /// Whether any value absorbs.
    bool visible() const { return opacity.maximum() > 0.0; }

    bool operator==(const TransferFunction&) const = default;
};

}  // namespace mote
