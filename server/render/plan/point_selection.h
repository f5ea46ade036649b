// SPDX-License-Identifier: GPL-3.0-or-later
//
// These functions tell which points of a step are drawn, and which of its leaves are in view: the latter
// traverses the octree and leaves a dense subtree at its root. They are pure and use all threads of the
// calling arena.
#pragma once

#include <bit>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "protocol/scene/curve.h"
#include "server/render/plan/frustum.h"
#include "server/render/plan/point_values.h"
#include "server/render/plan/step_volume.h"
#include "server/render/plan/thinning.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

/// How many points of each leaf are drawn, from its first, wherever they lie. Immutable once made, so that it
/// is shared by all pictures of a step in one style.
struct PointSelection {
    std::vector<std::uint32_t> drawn;  ///< leaves beyond its end draw nothing
    std::uint64_t points = 0;          ///< the sum
    /// By leaf that draws any: what a point of it weighs, over the mean of the plot, as the upper half of a
    /// float. Empty: all weigh `weight`.
    std::vector<std::uint16_t> weights = {};
    float weight = 1.0F;
    /// By leaf that draws any, if points are coloured by density: the level of its points (DensityLevels).
    std::vector<std::uint8_t> levels = {};

    std::uint8_t levelOf(std::size_t leaf) const { return levels.empty() ? std::uint8_t{0} : levels[leaf]; }
    /// Of a leaf's points.
    float weightOf(std::size_t leaf) const {
        return weights.empty() ? weight : std::bit_cast<float>(std::uint32_t{weights[leaf]} << 16);
    }
};

/// What points are drawn by, beside the step.
struct PointChoice {
    Curve fraction = Curve::constant(1.0);  ///< t -> how much of a leaf is points
    double share = 1.0;                     ///< of these that is drawn
    /// The layer's volume: what of a leaf it does not hold is points as well. Null: it holds all.
    std::shared_ptr<const StepVolume> volume = {};
    double meanWeight = 0.0;               ///< of the plot's particles; 0: they all count alike
    Thinning thinning = {};                ///< of points of different weights
    std::optional<PointShade> shade = {};  ///< by which they are coloured

    bool operator==(const PointChoice&) const = default;
    /// Whether leaves have points whatever their density.
    bool thin() const { return volume != nullptr && !volume->share.empty(); }
};

/// What the points of a step weigh over the mean of the plot.
struct StepWeight {
    double mean = 1.0;
    bool even = true;  ///< all of them so much
};

/// Throws storage::StorageError.
StepWeight stepWeight(const storage::ParticleStep& step, double meanWeight);

/// The mean alone, from the step's volume: while the octree is not in memory. Throws storage::StorageError.
StepWeight roughStepWeight(const storage::ParticleStep& step, double meanWeight);

/// Throws storage::StorageError.
PointSelection selectPoints(const storage::ParticleStep& step, const PointChoice& choice);

/// The least t from which on a curve is zero; infinite where it never ends in zero.
double zeroFrom(const Curve& curve);

/// The points that may be drawn: those of the leaves up to the density where the curve ends, and of denser
/// ones that are too thin for the volume, together with what lies close between them in the file. Throws
/// storage::StorageError.
std::vector<storage::PointRange> neededPoints(const storage::ParticleStep& step, const PointChoice& choice);

/// A bit a leaf, from the first: whether points of it can touch the picture. None at all: any leaf may, and
/// it is not worth its time to tell which. Leaves that draw nothing may be set or not. Throws
/// storage::StorageError.
std::vector<std::uint64_t> leavesInView(const storage::ParticleStep& step, const Frustum& frustum,
                                        const PointChoice& choice);

inline bool inView(const std::vector<std::uint64_t>& bits, std::size_t leaf) {
    return bits.empty() || (bits[leaf / 64] >> (leaf % 64) & 1) != 0;
}

}  // namespace mote::render
