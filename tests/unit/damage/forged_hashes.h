// SPDX-License-Identifier: GPL-3.0-or-later
//
// Damage that no hash tells, in datasets of any kind: every hash is made anew from what lies on the disk.
#pragma once

#include <filesystem>

namespace mote::test {

/// The blocks in the digests of all arrays, the files in the manifest, and the manifest's own digest. What
/// cannot be read as what it should be is left as it is.
void forgeHashes(const std::filesystem::path& dataset);

}  // namespace mote::test
