// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a manifest says of a hybrid volume: checked, and as values. Pure functions.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/dataset_kind.h"
#include "storage/hybrid/hybrid_limits.h"

namespace mote::storage {

/// Whether a manifest's `hybrid` is complete and in range and names files that it has. Errors: corrupt, with
/// the path of the field below `hybrid`.
Status checkHybrid(const proto::HybridManifest& hybrid, const FileNames& files);

/// The three numbers of a manifest that was checked.
GridSize gridSize(const google::protobuf::RepeatedField<std::uint32_t>& size);

/// The map from indices of the source's samples to the world; `hybrid` was checked.
glm::dmat4 indexToWorld(const proto::HybridManifest& hybrid);

/// nullptr if the dataset is of another kind or has no such step.
const proto::HybridStepEntry* findHybridStep(const proto::Manifest& manifest, std::uint32_t step);

/// The source's value of a point's code.
inline double pointValue(const proto::HybridManifest& hybrid, std::uint8_t code) {
    return hybrid.value_min() + code * (hybrid.value_max() - hybrid.value_min()) / (pointValueCodes - 1);
}

/// The error of a point's code, source minus low-resolution volume, in the source's unit.
inline double pointError(const proto::HybridStepEntry& step, std::uint8_t code) {
    return (code - errorCodeZero) * step.error_step();
}

}  // namespace mote::storage
