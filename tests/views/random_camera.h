// SPDX-License-Identifier: GPL-3.0-or-later
//
// Cameras of generated views: around what there is to see, inside it, with it behind, from far away, along
// its sides; at the ends of the angles; orthographic too. Pure functions of the numbers that they draw.
#pragma once

#include "protocol/scene/camera.h"
#include "tests/support/random.h"

namespace mote::test {

/// Aimed at `content`, if at anything. Not in each case valid: eye and target may coincide in their digits.
Camera anyCamera(Random& random, const Bounds& content);

}  // namespace mote::test
