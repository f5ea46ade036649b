// SPDX-License-Identifier: GPL-3.0-or-later
//
// Files to try things with that nobody needs to have: a body as a CT sees it, and a coil as a mesh. Functions
// of one thread.
#pragma once

#include <cstdint>
#include <filesystem>

#include "protocol/base/error.h"

namespace mote::prep {

inline constexpr std::uint32_t leastVoxels = 16, mostVoxels = 1024;

/// Writes an NRRD of 16-bit Hounsfield units, a trunk with spine, ribs, lungs and a heart, 400 mm wide.
/// `voxels`: along each axis, leastVoxels to mostVoxels. The same seed gives the same bytes. Errors: those of
/// DraftFile.
Status writePhantom(std::uint32_t voxels, std::uint64_t seed, const std::filesystem::path& output);

/// Writes an OBJ: wire wound about a ring, and the ring. Errors: those of DraftFile.
Status writeCoil(const std::filesystem::path& output);

}  // namespace mote::prep
