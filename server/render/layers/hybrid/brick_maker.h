// SPDX-License-Identifier: GPL-3.0-or-later
//
// A BrickMaker makes the corrected bricks of the error grid from a coarse grid and its residuals or its
// points (docs/PICTURE.md, "Hybrid volumes"), with normals from the corrected field but where points have
// their own. Used by one thread while a step is loaded; make() works in parallel.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <span>
#include <vector>

#include "protocol/base/error.h"
#include "server/render/plan/grid_field.h"
#include "storage/hybrid/hybrid_limits.h"

namespace mote::render {

/// 8 x 8 x 8 samples of the error grid, x fastest: what is to be added, in the source's unit.
using BrickResidual = std::span<const float, storage::residualBrickSamples>;
static_assert(storage::residualBrickSide == GridBricks::edge);

class BrickMaker {
  public:
    /// `step` has all but its bricks, and must outlive the maker. `size`: the error grid's, samples.
    BrickMaker(const GridField& step, const glm::uvec3& size);

    /// The residuals of one brick, told once; of the others they are 0. Beyond the grid they are ignored.
    /// Errors: resourceExhausted if there are too many.
    Status add(const glm::uvec3& brick, BrickResidual residual);
    /// A point, which must lie in the grid: a sample's code and that of its normal. No brick has both
    /// residuals and points. Errors: as above.
    Status addPoint(const glm::uvec3& sample, std::uint16_t code, std::uint8_t normal);
    /// Makes the bricks; called once.
    GridBricks make();

  private:
    /// The samples of a brick and one more on each side.
    static constexpr std::uint32_t wide = GridBricks::samples + 2;
    using Surroundings = std::array<float, std::size_t{wide} * wide * wide>;

    Status claim(const glm::uvec3& brick);
    Status claimReached(const glm::uvec3& brick, unsigned reach);
    void fill(std::size_t brick);
    void finish(std::size_t brick);
    float lowAt(const glm::uvec3& sample) const;
    float sampleAt(const glm::ivec3& sample) const;
    std::uint8_t normalAt(const Surroundings& around, const glm::uvec3& sample,
                          const glm::uvec3& inBrick) const;
    glm::vec3 gradient(const Surroundings& around, const glm::uvec3& at) const;

    const GridField& step_;
    GridBricks bricks_;
    glm::mat3 gradientToLayer_;
    std::array<std::vector<storage::Between>, 3>
        between_;  // each sample's place along an axis, in the coarse grid
    /// The samples of each corrected brick that were told, x fastest; points told their normals too.
    std::vector<std::bitset<storage::residualBrickSamples>> told_;
    bool ownNormals_ = false;
};

}  // namespace mote::render
