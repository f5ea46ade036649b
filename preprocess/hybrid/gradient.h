// SPDX-License-Identifier: GPL-3.0-or-later
//
// GradientNormals: one-byte normals from the samples of a grid, by central differences; at its ends by
// one-sided ones. A value that never changes; any thread.
#pragma once

#include <array>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>

#include "storage/hybrid/hybrid_limits.h"
#include "storage/hybrid/normal_table.h"

namespace mote::prep {

class GradientNormals {
  public:
    /// `toWorld` is from the grid's indices.
    GradientNormals(const storage::GridSize& size, const glm::dmat4& toWorld)
        : size_(size), fall_(-glm::inverse(glm::transpose(glm::dmat3(toWorld)))) {}

    /// The normal's code at sample `at`; `slices` are those of z - 1, z and z + 1, the same twice at the
    /// grid's ends. It points towards lower values, in the world.
    std::uint8_t code(const std::array<const float*, 3>& slices, const storage::GridSize& at) const {
        const std::size_t row = size_[0];
        const auto index = at[1] * row + at[0];
        const auto slope = [&](std::size_t axis, std::size_t stride) {
            const bool before = at[axis] > 0;
            const bool after = at[axis] + 1 < size_[axis];
            const float rise =
                slices[1][after ? index + stride : index] - slices[1][before ? index - stride : index];
            return before && after ? 0.5 * rise : 1.0 * rise;
        };
        const bool inside = at[2] > 0 && at[2] + 1 < size_[2];
        const double rise = slices[2][index] - slices[0][index];
        return table_.code(fall_ * glm::dvec3(slope(0, 1), slope(1, row), inside ? 0.5 * rise : rise));
    }

  private:
    storage::GridSize size_;
    glm::dmat3 fall_;  ///< from a gradient over indices to the direction of fall over the world
    storage::NormalTable table_;
};

}  // namespace mote::prep
