// SPDX-License-Identifier: GPL-3.0-or-later
//
// A residual's file (docs/FORMAT.md) from its encoded parts. Holds one node of the tree at a time, and of all
// others where they are. A function without state.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "protocol/scene/error.h"
#include "storage/hybrid/residual_encoder.h"

namespace mote::storage {

/// Makes `path` from parts in any order; part.scratch is an index into `scratches`. The same bricks give the
/// same bytes, whatever their parts. Errors: as writeVdbFile and ScratchFile::read.
Status writeResidual(const std::filesystem::path& path, const ResidualCoding& coding,
                     const std::vector<ResidualPart>& parts,
                     std::span<const std::unique_ptr<ScratchFile>> scratches);

}  // namespace mote::storage
