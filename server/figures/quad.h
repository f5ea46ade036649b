// SPDX-License-Identifier: GPL-3.0-or-later
//
// A quadrangle that a text covers, and whether two meet: labels that are turned stand closer than boxes
// around them would let them. A value; pure functions.
#pragma once

#include <array>
#include <glm/vec2.hpp>

#include "server/figures/marks.h"
#include "server/figures/typeface.h"

namespace mote::server {

using Quad = std::array<glm::dvec2, 4>;  ///< convex, its corners in turn

Quad quadOf(const Box& box);
/// That a text covers as it is drawn, with room for what hangs below the line.
Quad quadOf(const TextMark& text, const Typeface& typeface);
Box boxAround(const Quad& quad);
/// Whether they have an area in common.
bool meet(const Quad& first, const Quad& second);

}  // namespace mote::server
