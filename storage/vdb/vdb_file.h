// SPDX-License-Identifier: GPL-3.0-or-later
//
// OpenVDB's files, written so that a full disk is an error and the same grid gives the same bytes. A function
// without state.
#pragma once

#include <openvdb/version.h>

#include <cstdint>
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <memory>
#include <vector>

#include "protocol/scene/error.h"

namespace openvdb {
OPENVDB_USE_VERSION_NAMESPACE
namespace OPENVDB_VERSION_NAME {
class GridBase;
namespace math {
class Transform;
}
}  // namespace OPENVDB_VERSION_NAME
}  // namespace openvdb

namespace mote::storage {

/// From a grid's indices to the world.
std::shared_ptr<openvdb::math::Transform> vdbTransform(const glm::dmat4& indexToWorld);

/// How the values of active samples are written: zip brick by brick, or as they are, for a file that is
/// packed as a whole.
enum class VdbValues { zip, plain };

/// The same as OpenVDB says it.
std::uint32_t vdbCompression(VdbValues values);

/// Writes `path`, which is replaced, with an identity made from the bytes, where OpenVDB takes a random one.
/// Grids have names of their own; their statistics (addStatsMetadata) are the caller's to add. The file is
/// not synced. Errors: resourceExhausted (it cannot be written whole), internal (OpenVDB's own), those of a
/// StorageError that a grid throws.
Status writeVdbFile(const std::filesystem::path& path,
                    const std::vector<std::shared_ptr<openvdb::GridBase>>& grids,
                    VdbValues values = VdbValues::zip);

}  // namespace mote::storage
