// SPDX-License-Identifier: GPL-3.0-or-later
//
// verifyDataset: everything that can be checked of a dataset on disk: its manifest, every file's size and
// hash, every block of every array, every octree; and that no file is missing or there besides.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "protocol/scene/error.h"

namespace mote::storage {

/// What is wrong, one Error each (at most 1000); nothing where the dataset is whole. `progress` takes the
/// done share, 0 to 1; a `cancelled` error is the only one where `cancelled` said so.
std::vector<Error> verifyDataset(const std::filesystem::path& directory,
                                 const std::function<bool()>& cancelled = {},
                                 const std::function<void(double)>& progress = {});

}  // namespace mote::storage
