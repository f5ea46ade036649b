// SPDX-License-Identifier: GPL-3.0-or-later
//
// What lies between two affine transforms: each is a stretch, then a rotation, then a shift (polar
// decomposition; K. Shoemake and T. Duff, Matrix animation and polar decomposition, 1992). Pure functions.
#pragma once

#include <glm/mat4x4.hpp>

namespace mote {

/// Whether there is something in between that a layer may have: not where one is a mirror image and the other
/// is none.
bool canMixTransforms(const glm::dmat4& from, const glm::dmat4& to);

/// At a share of the way, 0 to 1, of two that can be mixed: the rotation the shorter way at an even rate,
/// stretch and shift evenly.
glm::dmat4 mixTransforms(const glm::dmat4& from, const glm::dmat4& to, double share);

}  // namespace mote
