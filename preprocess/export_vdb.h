// SPDX-License-Identifier: GPL-3.0-or-later
//
// The density volume of a step as an OpenVDB file, for any tool that reads these. The only place with
// OpenVDB. One thread.
#pragma once

#include <filesystem>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// Writes a fog volume "density" in layer space: voxel (i, j, k) is the cell with that index along the three
/// axes, the box is [-1, 1]^3; axes and bounds are metadata. `output` appears by one rename. Errors:
/// notFound, corrupt, alreadyExists, permissionDenied, resourceExhausted. Throws storage::StorageError where
/// the volume is damaged.
Status exportVdb(const std::filesystem::path& dataset, const proto::Manifest& manifest, std::uint32_t step,
                 const std::filesystem::path& output);

}  // namespace mote::prep
