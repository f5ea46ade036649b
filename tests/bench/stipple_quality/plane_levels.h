// SPDX-License-Identifier: GPL-3.0-or-later
//
// A hierarchy's evenness at all densities, from the dots that replay draws. Pure functions.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "server/render/layers/stipple/replay.h"
#include "tests/support/plane_measures.h"

namespace mote::bench {

/// The shares of all points that are measured: 0.95, 0.9, ... 0.05, as long as 250 points are left.
std::vector<double> levels(std::uint32_t points);

/// What replay draws where a share is wanted everywhere.
std::vector<glm::dvec2> drawnAt(const render::StippleReplay& replay, double share);

/// The worst of several measures, each by itself.
test::PlaneMeasures worst(std::span<const test::PlaneMeasures> measures);

/// Whether they meet the bars: rho .65, NN .86, E 1.05, areaCV .085, lowE .013.
bool meetsBars(const test::PlaneMeasures& measures);

/// The longest move of a hierarchy, in mean distances of the points that are left then; the last `but` points
/// aside.
double longestMove(const storage::StippleHierarchy& hierarchy, std::uint32_t but);

}  // namespace mote::bench
