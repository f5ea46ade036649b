// SPDX-License-Identifier: GPL-3.0-or-later
//
// These functions tell which points of a step are drawn, and which of its leaves are in view: the latter
// traverses the octree and leaves a dense subtree at its root. They are pure and use all threads of the
// calling arena.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/scene/curve.h"
#include "server/render/plan/frustum.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

/// How many points of each leaf are drawn, from its first, wherever they lie. Immutable once made, so that it
/// is shared by all pictures of a step in one style.
struct PointSelection {
    std::vector<std::uint32_t> drawn;  ///< leaves beyond its end draw nothing
    std::uint64_t points = 0;          ///< the sum
};

/// Where the curve's fraction is multiplied by `share`. Throws storage::StorageError.
PointSelection selectPoints(const storage::ParticleStep& step, const Curve& pointFraction, double share);

/// The least t from which on a curve is zero; infinite where it never ends in zero.
double zeroFrom(const Curve& curve);

/// The points of the leaves up to the density where the curve ends, from the first: no other is drawn. Throws
/// storage::StorageError.
std::uint64_t pointsUpTo(const storage::ParticleStep& step, const Curve& pointFraction);

/// A bit a leaf, from the first: whether points of it can touch the picture. None at all: any leaf may, and
/// it is not worth its time to tell which. Leaves above the density where `pointFraction` ends may be set or
/// not. Throws storage::StorageError.
std::vector<std::uint64_t> leavesInView(const storage::ParticleStep& step, const Frustum& frustum,
                                        const Curve& pointFraction);

inline bool inView(const std::vector<std::uint64_t>& bits, std::size_t leaf) {
    return bits.empty() || (bits[leaf / 64] >> (leaf % 64) & 1) != 0;
}

}  // namespace mote::render
