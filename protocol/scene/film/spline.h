// SPDX-License-Identifier: GPL-3.0-or-later
//
// Cubic splines through values at uneven times, once continuously differentiable: cubic Hermite polynomials
// with tangents of the parabola through three neighbours. A tangent is never more than three times as long as
// the chord on either side, so that what stands still stays still and nothing swings far beyond its ends.
// Pure functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace mote {

inline double lengthOf(double value) {
    return std::abs(value);
}
inline double lengthOf(const glm::dvec3& value) {
    return glm::length(value);
}

/// A change per second, where a way with the rate `before` that took `secondsBefore` meets one with the rate
/// `after`.
template <class Value>
Value tangentBetween(const Value& before, double secondsBefore, const Value& after, double secondsAfter) {
    const double whole = secondsBefore + secondsAfter;
    const Value tangent = (secondsAfter / whole) * before + (secondsBefore / whole) * after;
    const double most = 3.0 * std::min(lengthOf(before), lengthOf(after)), length = lengthOf(tangent);
    return length > most ? (most / length) * tangent : tangent;
}

/// A way from one value to another, with its tangents times its seconds.
template <class Value>
struct HermiteWay {
    Value from, to;
    Value leaving, arriving;

    Value operator()(double share) const {
        const double rest = 1.0 - share;
        // As what is added to a linear way, so that a linear one is exactly that.
        const Value chord = to - from;
        return from + share * chord +
               (share * rest) * (rest * (leaving - chord) - share * (arriving - chord));
    }
};

}  // namespace mote
