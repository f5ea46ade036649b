// SPDX-License-Identifier: GPL-3.0-or-later
//
// Formats that are known by how they begin and not read as volumes: what such a file is, and what makes one
// that is read of it. Functions without state.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace mote::prep {

/// "is a netCDF file, which is not read as a volume; ..." of a file that begins with `begin` (some 512
/// bytes); nothing where the format is not known.
std::optional<std::string> knownNoVolume(std::string_view begin);

/// The same of a folder that is a file to those who write it.
std::optional<std::string> knownNoVolumeFolder(const std::filesystem::path& folder);

}  // namespace mote::prep
