// SPDX-License-Identifier: GPL-3.0-or-later
//
// The low-resolution volume of a source: filtered, as codes, with normals. Functions on the caller's oneTBB
// threads; the same source gives the same bytes for any number of threads and any slabs.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "preprocess/hybrid/slab_window.h"
#include "preprocess/hybrid/value_range.h"
#include "preprocess/hybrid/volume_plan.h"
#include "storage/hybrid/hybrid_file.h"

namespace mote::prep {

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

/// Values become codes: rounded to the nearest, where they are at most the range's; downwards for `under`,
/// whose values may lie below it.
LowVolume encodeLow(const VolumePlan& plan, const ValueRange& range, std::span<const float> values);

/// The direction towards lower values, in the world, by central differences; one code a sample.
std::vector<std::uint8_t> lowNormals(const LowVolume& low, const glm::dmat4& lowToWorld);

}  // namespace mote::prep
