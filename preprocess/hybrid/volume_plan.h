// SPDX-License-Identifier: GPL-3.0-or-later
//
// VolumePlan: what a request for a hybrid volume comes to for a source of a given shape. Values and pure
// functions.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <optional>

#include "preprocess/volume/volume_source.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "storage/hybrid/hybrid_limits.h"

namespace mote::prep {

enum class LowFilter {
    cubic,  ///< Keys' cubic, stretched to the low-resolution volume's spacing
    box,    ///< the mean of the source over each sample's cell
    under,  ///< cubic, lowered until it overestimates no sample of the source by more than an allowance
};

struct VolumePlan {
    storage::GridSize source{}, low{}, error{};
    LowFilter filter = LowFilter::cubic;
    double allowance = 0.0;  ///< of `under`: a fraction of the range of values
    double threshold = 0.0;  ///< least error that counts, a fraction of the range of values; or:
    std::optional<std::uint64_t> maxPoints;  ///< the samples of greatest error
    std::uint32_t pointBytes = 0;            ///< 5, 6 or 9; 0: no points
    bool residual = false;
    std::uint32_t valueBits = 8;  ///< of a code of the low-resolution volume, 8 or 16
    glm::dmat4 indexToWorld{1.0};
};

/// What can be said of a request before its inputs are looked at. Errors: invalidArgument with the field's
/// path.
Status checkVolumeJob(const proto::VolumeJob& job);

/// `job` was checked. Errors: invalidArgument (6 bytes a point on a larger error grid), resourceExhausted
/// (grids larger than a dataset may have).
Result<VolumePlan> planVolume(const proto::VolumeJob& job, const VolumeShape& shape);

/// The map from indices of a grid over the source's box to the world.
glm::dmat4 gridToWorld(const VolumePlan& plan, const storage::GridSize& grid);

}  // namespace mote::prep
