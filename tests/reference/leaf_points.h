// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where the points of a step lie (docs/FORMAT.md), leaf by leaf, for the reference. Pure.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>

#include "protocol/scene/drawn_points.h"
#include "storage/particles/particle_step.h"

namespace mote::reference {

/// Every third bit of a Morton code: a cell's place along one axis.
inline double placeOf(std::uint64_t morton, int axis) {
    double place = 0.0;
    for (int bit = 0; bit < 21; ++bit) {
        if (morton >> (3 * bit + axis) & 1U) place += std::ldexp(1.0, bit);
    }
    return place;
}

/// Calls take(point, place in layer space) for each drawn point of a step, with a fraction for each leaf.
template <class Fraction, class Take>
void forPoints(const storage::ParticleStep& step, const Fraction& fraction, const Take& take) {
    const auto nodes = step.nodes();
    const auto leaves = step.leaves();
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
        const auto node = leaves.node[leaf];
        const auto drawn =
            drawnPoints(fraction(leaf), leaves.pointCount[leaf], nodes.level[node], nodes.morton[node]);
        const glm::dvec3 corner(placeOf(nodes.morton[node], 0), placeOf(nodes.morton[node], 1),
                                placeOf(nodes.morton[node], 2));
        auto point = leaves.pointBegin[leaf];
        for (const auto& p : step.positions(point, drawn)) {
            const glm::dvec3 inCell = (glm::dvec3(p.x, p.y, p.z) + 0.5) / 65536.0;
            take(point++, 2.0 * (corner + inCell) * std::ldexp(1.0, -nodes.level[node]) - 1.0);
        }
    }
}

}  // namespace mote::reference
