// SPDX-License-Identifier: GPL-3.0-or-later
//
// Text in messages is UTF-8, file names are bytes. Pure functions.
#pragma once

#include <string>
#include <string_view>

namespace mote::server {

/// Whether all of it is UTF-8 as Unicode defines it: no overlong forms, no surrogates.
bool isUtf8(std::string_view text);

/// Each byte that belongs to no character becomes "?".
std::string toUtf8(std::string_view text);

}  // namespace mote::server
