// SPDX-License-Identifier: GPL-3.0-or-later
//
// Keys say what a picture or a film shows, so that --resume knows its own. Pure; any thread.
#pragma once

#include <string>
#include <string_view>

namespace mote::client {

/// 32 hexadecimal digits, of a text that holds all that decides the bytes.
std::string keyOf(std::string_view text);

}  // namespace mote::client
