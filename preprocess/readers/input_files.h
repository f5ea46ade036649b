// SPDX-License-Identifier: GPL-3.0-or-later
//
// The files that the inputs of a job stand for: a file, a name with %T, a folder. Functions without state.
#pragma once

#include <filesystem>
#include <vector>

#include "preprocess/job.h"
#include "protocol/base/error.h"

namespace mote::prep {

struct InputFile {
    std::filesystem::path path;
    bool listed = true;  ///< false: found in a folder or by a pattern, so that it may be something else
};

/// All files of all inputs: those of a name with %T or %06T ("run_%T.h5") by their numbers, those of a folder
/// by the numbers in their names, else by their names; hidden files and folders in it are left out. Folders
/// that are files to those who write them (ADIOS2, Zarr) stay as they are. Errors: notFound,
/// resourceExhausted (more than 100 000), invalidArgument (none).
Result<std::vector<InputFile>> inputFiles(const std::vector<std::filesystem::path>& inputs);

}  // namespace mote::prep
