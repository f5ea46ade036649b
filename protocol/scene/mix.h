// SPDX-License-Identifier: GPL-3.0-or-later
//
// What lies between two values, or two curves, at a share of the way, 0 to 1. At 0 and 1 and between equals
// it is exactly the one or the other, it lies never beyond them, and what ascends still does. Pure functions.
#pragma once

#include <algorithm>
#include <glm/vec3.hpp>
#include <vector>

#include "protocol/scene/curve.h"

namespace mote {

inline double mix(double from, double to, double share) {
    // Not from + share * (to - from): that would not keep the order of two pairs to the last digit.
    return std::clamp((1.0 - share) * from + share * to, std::min(from, to), std::max(from, to));
}

inline glm::dvec3 mix(const glm::dvec3& from, const glm::dvec3& to, double share) {
    return {mix(from.x, to.x, share), mix(from.y, to.y, share), mix(from.z, to.z, share)};
}

/// Of unit vectors: by the shortest rotation; of opposite ones about an axis that their digits choose.
glm::dvec3 mixDirections(const glm::dvec3& from, const glm::dvec3& to, double share);

/// A curve and the colours of its knots, linear RGB; or none.
struct ColoredCurve {
    Curve curve;
    std::vector<glm::dvec3> colors = {};

    bool operator==(const ColoredCurve&) const = default;
};

/// Whether there is something in between: one has colours where the other has, and the knots of both together
/// are not more than a curve may have.
bool canMix(const ColoredCurve& from, const ColoredCurve& to);

/// At a share of the way, 0 to 1; of two that can be mixed.
ColoredCurve mixCurves(const ColoredCurve& from, const ColoredCurve& to, double share);

}  // namespace mote
