// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which leaves are in view and how many points of each are drawn (METHODS: a traversal for points skips a
// dense subtree at its root). Pure functions.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/scene/curve.h"
#include "server/render/frustum.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

/// The least t from which on a curve is zero; infinite where it never ends in zero.
double zeroFrom(const Curve& curve);

/// For each leaf 1 where points of it can touch the picture and its density lies below `densityLimit`, else
/// 0. Throws storage::StorageError where the octree contradicts itself.
std::vector<std::uint8_t> visibleLeaves(const storage::ParticleStep& step, const Frustum& frustum,
                                        double densityLimit);

/// For each leaf the number of its points that are drawn where the curve's fraction is multiplied by `share`.
/// Throws storage::StorageError as above.
std::vector<std::uint32_t> selectPoints(const storage::ParticleStep& step, const Frustum& frustum,
                                        const Curve& pointFraction, double share);

}  // namespace mote::render
