// SPDX-License-Identifier: GPL-3.0-or-later
//
// Takes files out of the page cache, so that what comes next reads from the disk, and says whether it worked.
// Pure functions, but for the files.
#pragma once

#include <filesystem>

namespace mote::bench {

/// Asks the kernel to forget every file of a folder. Throws std::system_error.
void evict(const std::filesystem::path& folder);

/// The share of the folder's bytes that the kernel holds. Throws std::system_error.
double cachedShare(const std::filesystem::path& folder);

}  // namespace mote::bench
