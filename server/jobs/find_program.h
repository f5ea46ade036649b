// SPDX-License-Identifier: GPL-3.0-or-later
//
// Programs of the system, by name. A pure function, but for looking at files.
#pragma once

#include <filesystem>
#include <string>

namespace mote::server {

/// Where PATH has it; the name alone where it is nowhere.
std::filesystem::path findProgram(const std::string& name);

}  // namespace mote::server
