// SPDX-License-Identifier: GPL-3.0-or-later
//
// What lies between two curves: knot by knot where both have equally many, else by their values at the knots
// of both. Pure functions.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "protocol/scene/curve.h"
#include "protocol/scene/field_visitor.h"

namespace mote {

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

/// Shows a visitor a curve without colours.
void visitCurve(FieldVisitor& visitor, Curve& value, const Curve& other);

}  // namespace mote
