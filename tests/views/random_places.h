// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where the layers of a generated view stand: together, inside and behind each other, at sizes that have
// nothing in common; turned, sheared, mirrored. Pure functions of the numbers that they draw.
#pragma once

#include <vector>

#include "protocol/scene/bounds.h"
#include "tests/support/random.h"

namespace mote::test {

/// Layer to world for each of the layers with these bounds, none of them singular. An identity is to be left
/// out of the view.
std::vector<glm::dmat4> anyTransforms(Random& random, const std::vector<Bounds>& layers);

}  // namespace mote::test
