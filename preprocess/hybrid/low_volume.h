// SPDX-License-Identifier: GPL-3.0-or-later
//
// The low-resolution volume of a source: filtered, as codes, with normals. Functions on the caller's oneTBB
// threads; the same source gives the same bytes for any number of threads and any slabs.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <span>
#include <vector>

#include "preprocess/hybrid/value_range.h"
#include "preprocess/hybrid/volume_plan.h"
#include "preprocess/volume/volume_source.h"
#include "protocol/base/error.h"
#include "storage/hybrid/hybrid_file.h"
#include "storage/hybrid/hybrid_limits.h"
#include "storage/hybrid/normal_table.h"

namespace mote::prep {

/// The slices of a source that are in memory, a window that moves in ascending z and reads each
/// slice once. What is not finite becomes the least value. One owner; slices may be read from any thread
/// between moves.
class SlabWindow {
  public:
    /// `source` must outlive this. `least` takes the place of values that are not finite.
    SlabWindow(VolumeSource& source, double least)
        : source_(source), least_(static_cast<float>(least)), slice_(source.shape().voxelsOfSlice()) {}

    /// Makes slices [z0, z1) the window; neither end may lie before the last one's. Errors: the source's.
    Status cover(std::uint32_t z0, std::uint32_t z1);

    std::uint32_t begin() const { return begin_; }
    std::uint32_t end() const { return end_; }
    /// A slice of the window, x fastest.
    std::span<const float> slice(std::uint32_t z) const {
        return std::span(values_).subspan((z - begin_) * slice_, slice_);
    }

  private:
    VolumeSource& source_;
    float least_;
    std::size_t slice_;  ///< values of one
    std::uint32_t begin_ = 0, end_ = 0;
    std::vector<float> values_;
};

/// One-byte normals from the samples of a grid, by central differences; at its ends by
/// one-sided ones. A value that never changes; any thread.
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

/// Codes of the low-resolution volume, x fastest: value = min + code * step.
struct LowVolume {
    storage::GridSize size{};
    double min = 0.0, step = 0.0;
    std::vector<std::uint8_t> codes8;
    std::vector<std::uint16_t> codes16;  ///< one of the two is empty

    std::size_t slice() const { return std::size_t{size[0]} * size[1]; }
    /// The values of slice z, as whoever reads the dataset has them.
    void decode(std::uint32_t z, std::span<float> values) const;
    storage::LowCodes codes() const;
};

/// Slices [k0, k1) of the low-resolution volume, by cubic or box, between the range's ends. `seen` gets every
/// slice of the source that was read, once, in ascending order, `together` of them at a time: slices [z0, z1)
/// of the window. Errors: the source's, cancelled.
Result<std::vector<float>> filterSlices(
    VolumeSource& source, const VolumePlan& plan, const ValueRange& range, std::uint32_t k0, std::uint32_t k1,
    std::uint32_t together,
    const std::function<Status(const SlabWindow&, std::uint32_t z0, std::uint32_t z1)>& seen);

/// Values become codes: rounded to the nearest, if they are at most the range's; downwards for `under`,
/// whose values may lie below it.
LowVolume encodeLow(const VolumePlan& plan, const ValueRange& range, std::span<const float> values);

/// The direction towards lower values, in the world, by central differences; one code a sample.
std::vector<std::uint8_t> lowNormals(const LowVolume& low, const glm::dmat4& lowToWorld);

/// For volumes that overestimate no sample of the source by more than an allowance (section 3.2.1.2 of the
/// dissertation).
///
/// The dissertation takes minima, which underestimates wide areas. Here each sample x of the source that the
/// trilinear interpolation of `low` overshoots by v(x) beyond the allowance asks its (at most eight)
/// neighbours i of weight w_i for a fall of v w_i / sum(w_j^2), the least change that takes v away
/// (Kaczmarz's projection); each neighbour falls by the greatest that is asked of it. Every x then falls by
/// v(x) at least.
///
/// Lowers `low`, all slices of it, by what the source's slices [z0, z1) ask for; `falls` is as large and
/// holds the greatest falls so far. What several calls for parts of the source found is combined by taking
/// greatest falls. Errors: the source's, cancelled.
Status findFalls(VolumeSource& source, const VolumePlan& plan, const ValueRange& range,
                 std::span<const float> low, std::uint32_t z0, std::uint32_t z1, std::uint32_t together,
                 const std::function<Status(std::uint32_t z)>& progress, std::span<float> falls);

}  // namespace mote::prep
