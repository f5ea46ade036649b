// SPDX-License-Identifier: GPL-3.0-or-later
//
// The token that a client must know. Pure functions.
#pragma once

#include <string>
#include <string_view>

namespace mote::server {

/// 32 bytes from the kernel's random generator, hexadecimal. Throws std::system_error where it has none.
std::string makeToken();

/// Takes the same time wherever the two differ, so that a guess learns nothing from it.
bool sameToken(std::string_view expected, std::string_view given);

}  // namespace mote::server
