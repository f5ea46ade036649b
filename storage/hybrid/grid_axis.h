// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where the samples of one grid lie in another that covers the same box, and in the world. Values lie at cell
// centres; beyond the first and the last a grid is constant. Pure functions, shared by the job, the renderers
// and the tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/mat4x4.hpp>

#include "storage/hybrid/hybrid_limits.h"

namespace mote::storage {

/// The place of sample j of `samples` in indices of a grid of `others`: 0 is the centre of its first cell.
inline double placeIn(std::uint32_t j, std::uint32_t samples, std::uint32_t others) {
    return (j + 0.5) * others / samples - 0.5;
}

/// A place between two samples: (1 - fraction) * value[first] + fraction * value[second].
struct Between {
    std::uint32_t first = 0, second = 0;
    float fraction = 0.0F;  ///< in [0, 1)
};

/// Linear interpolation at `place` of a grid of `samples`, constant beyond its ends.
inline Between between(double place, std::uint32_t samples) {
    const double inside = std::clamp(place, 0.0, samples - 1.0);
    const double below = std::floor(inside);
    const auto first = static_cast<std::uint32_t>(below);
    return {first, std::min(first + 1, samples - 1), static_cast<float>(inside - below)};
}

/// The map from indices of `grid` to the world, where `source` covers the same box and has `indexToWorld`.
inline glm::dmat4 gridToWorld(const glm::dmat4& indexToWorld, const GridSize& source, const GridSize& grid) {
    glm::dvec3 first(0.0);
    glm::dvec3 spacing(1.0);
    for (int a = 0; a < 3; ++a) {
        const auto at = static_cast<std::size_t>(a);
        first[a] = placeIn(0, grid[at], source[at]);
        spacing[a] = static_cast<double>(source[at]) / grid[at];
    }
    return indexToWorld * glm::scale(glm::translate(glm::dmat4(1.0), first), spacing);
}

}  // namespace mote::storage
