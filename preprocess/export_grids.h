// SPDX-License-Identifier: GPL-3.0-or-later
//
// What of a dataset is written for other tools, as OpenVDB grids. Functions without state; one thread.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "storage/vdb/vdb_file.h"

namespace mote::prep {

using VdbGrids = std::vector<std::shared_ptr<openvdb::GridBase>>;

/// Of particles: a fog volume "density" in layer space: voxel (i, j, k) is the cell with that index along the
/// three axes, the box is [-1, 1]^3; axes and bounds are metadata. Errors: notFound, corrupt. Throws
/// storage::StorageError where the volume is damaged.
Result<VdbGrids> densityGrids(const std::filesystem::path& dataset, const proto::Manifest& manifest,
                              std::uint32_t step);

/// Of a hybrid volume, in the source's unit and world: "volume", all samples of the low-resolution volume,
/// and where there is one "residual", what is to be added to it, interpolated linearly, at the samples of the
/// error grid. Errors: notFound, corrupt.
Result<VdbGrids> hybridGrids(const std::filesystem::path& dataset, const proto::Manifest& manifest,
                             std::uint32_t step);

}  // namespace mote::prep
