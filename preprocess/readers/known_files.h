// SPDX-License-Identifier: GPL-3.0-or-later
//
// Formats that are known by how they begin and not read: what such a file is, and what makes one that is read
// of it. Functions without state.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace mote::prep {

enum class WantedAs : std::uint8_t { particles, volume };

/// "is a VTK file, which is not read as particles; ...", of a file that begins with `begin` (some 512 bytes)
/// and is named `name`, without its folder; nothing where the format is not known, or read. `sure`: not of
/// the few letters that the names of a table may begin with, too.
std::optional<std::string> knownFile(std::string_view begin, std::string_view name, WantedAs wanted,
                                     bool sure = false);

/// The same of a folder that is a file to those who write it (ADIOS2 where that is not read, Zarr, ...).
std::optional<std::string> knownFolder(const std::filesystem::path& folder, WantedAs wanted);

}  // namespace mote::prep
