// SPDX-License-Identifier: GPL-3.0-or-later
//
// What HDF5 writes of a step file: superblock, groups, arrays that are allocated and not filled, attributes.
// One call at a time in a process.
#pragma once

#include <filesystem>

#include "storage/particles/step_file.h"

namespace mote::storage {

/// Writes over `path`. Errors: internal.
Result<StepFile::Places> layOutStep(const std::filesystem::path& path, const StepShape& shape,
                                    const StepAttributes& attributes);

}  // namespace mote::storage
