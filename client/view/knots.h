// SPDX-License-Identifier: GPL-3.0-or-later
//
// Knots: what a hand does to the knots of a curve. Pure functions; knots ascend in x and their y lies within
// [0, 1].
#pragma once

#include <cstddef>
#include <vector>

#include "protocol/scene/curve.h"

namespace mote::client {

/// What an axis spans; low < high.
struct Interval {
    double low = 0.0;
    double high = 1.0;

    bool operator==(const Interval&) const = default;
};

/// More cannot be told apart by hand; the schema allows 256.
inline constexpr std::size_t mostKnots = 64;

/// Where a knot may be moved: between its neighbours, within the axis.
Curve::Knot heldKnot(const std::vector<Curve::Knot>& knots, std::size_t index, Curve::Knot to,
                     const Interval& axis);

/// Where a knot at x belongs: behind those that are not above it.
std::size_t knotPlace(const std::vector<Curve::Knot>& knots, double x);

}  // namespace mote::client
