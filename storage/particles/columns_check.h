// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a manifest says of the columns and statistics of a particle plot, held to itself. Pure functions.
#pragma once

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "storage/dataset_kind.h"

namespace mote::storage {

inline constexpr int maxColumns = 256;
inline constexpr int maxStatistics = 1024;

/// Columns, ids, mass, units and the names of statistics. Errors: corrupt, with the field.
Status checkColumns(const proto::ParticlesManifest& particles);
/// What a step has of them. Errors: corrupt, with the field.
Status checkStepColumns(const proto::ParticlesManifest& particles, const proto::ParticleStepEntry& step,
                        const FileNames& files);

}  // namespace mote::storage
