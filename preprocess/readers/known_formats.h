// SPDX-License-Identifier: GPL-3.0-or-later
//
// Formats that are known by how they begin and not read as particles: what such a file is, and what makes one
// that is read of it. Functions without state.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace mote::prep {

/// "is a VTK file; mote-prep volume reads ...", of a file that begins with `begin` (some 512 bytes) and is
/// named `name`; nothing where the format is not known. `name` is without its folder. `sure`: not of the few
/// letters that the names of a table may begin with, too.
std::optional<std::string> knownFormat(std::string_view begin, std::string_view name, bool sure = false);

/// The same of a folder that is a file to those who write it (ADIOS2, Zarr, ...).
std::optional<std::string> knownFolder(const std::filesystem::path& folder);

}  // namespace mote::prep
