// SPDX-License-Identifier: GPL-3.0-or-later
//
// Whole files as strings. Plain functions.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace mote::test {

/// Of a file that is not there: nothing.
std::string bytesOfFile(const std::filesystem::path& path);

/// Writes anew what lies there, or what does not.
void writeFile(const std::filesystem::path& path, std::string_view bytes);

}  // namespace mote::test
