// SPDX-License-Identifier: GPL-3.0-or-later
//
// OpenVDB volumes: one grid of floats, doubles or 32-bit integers, in the box of its active voxels. Called
// from one thread.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "preprocess/volume/volume_source.h"

namespace mote::prep {

bool beginsAsVdb(std::string_view bytes);

/// The grid of the name `field`; "": the first one that can be read. The grid's nodes are in memory, and the
/// voxels of those slices that were asked for last. Errors: notFound (no such grid, none at all), unsupported
/// (vectors, points, a transform that is not linear), corrupt, those of fileStream.
Result<std::unique_ptr<VolumeSource>> openVdb(const std::filesystem::path& path, const std::string& field);

}  // namespace mote::prep
