// SPDX-License-Identifier: GPL-3.0-or-later
//
// OpenVDB's files, written so that a full disk is an error and the same grid gives the same bytes. A function
// without state.
#pragma once

#include <openvdb/version.h>

#include <filesystem>
#include <memory>
#include <vector>

#include "protocol/scene/error.h"

namespace openvdb {
OPENVDB_USE_VERSION_NAMESPACE
namespace OPENVDB_VERSION_NAME {
class GridBase;
}
}  // namespace openvdb

namespace mote::storage {

/// Writes `path`, which is replaced: zip, active values alone, and an identity made from the bytes, where
/// OpenVDB takes a random one. The file is not synced. Errors: resourceExhausted (it cannot be written
/// whole), internal (OpenVDB's own).
Status writeVdbFile(const std::filesystem::path& path,
                    const std::vector<std::shared_ptr<openvdb::GridBase>>& grids);

}  // namespace mote::storage
