// SPDX-License-Identifier: GPL-3.0-or-later
//
// hierarchy.h5 and hierarchy.digest of a dataset of kind "stipple" (docs/FORMAT.md): a StippleHierarchy on
// disk. Functions without state; writing has one thread at a time in a process (HDF5), reading any.
#pragma once

#include <filesystem>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "storage/stipple/stipple_hierarchy.h"

namespace mote::storage {

inline constexpr const char* hierarchyName = "hierarchy";

/// Makes both files in `directory`; the hierarchy must be consistent. Errors: as writeArrayFile.
Status writeHierarchy(const std::filesystem::path& directory, const StippleHierarchy& hierarchy);

/// Reads all of it, every byte held to its digest, and checks it (checkHierarchy) and that it has the
/// manifest's points and moves. Errors: notFound, corrupt (with file and array), invalidArgument (a dataset
/// of another kind).
Result<StippleHierarchy> readHierarchy(const std::filesystem::path& directory,
                                       const proto::Manifest& manifest);

}  // namespace mote::storage
