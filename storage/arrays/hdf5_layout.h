// SPDX-License-Identifier: GPL-3.0-or-later
//
// What HDF5 writes of a dataset's file: superblock, groups, arrays that are allocated and not filled,
// attributes. The arrays' bytes go to their places without it. One call at a time in a process: HDF5 is not
// thread-safe.
#pragma once

#include <filesystem>
#include <vector>

#include "protocol/scene/error.h"
#include "storage/arrays/array_layout.h"

namespace mote::storage {

/// Makes `path`, which must be new, with room for everything before HDF5 sees it, and lays it out. Places in
/// the order of the arrays. The same layout gives the same bytes. Errors: resourceExhausted (disk full),
/// permissionDenied, alreadyExists, internal; a part of the file may be left.
Result<std::vector<ArrayPlace>> layOutFile(const std::filesystem::path& path, const FileLayout& layout);

}  // namespace mote::storage
