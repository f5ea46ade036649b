// SPDX-License-Identifier: GPL-3.0-or-later
//
// Texts in JSON that is written by hand, a line at a time. A pure function.
#pragma once

#include <string>
#include <string_view>

namespace mote {

/// A JSON string with its quotes, fit for a terminal too.
std::string jsonString(std::string_view text);

}  // namespace mote
