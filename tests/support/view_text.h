// SPDX-License-Identifier: GPL-3.0-or-later
//
// Views written as JSON in a test, as a user writes them. Pure functions.
#pragma once

#include <string_view>

#include "protocol/scene/view.h"

namespace mote::test {

/// Apostrophes stand for quotation marks, and a layer's dataset may be left out. Throws
/// std::invalid_argument, with the parser's words, where the text is no valid view.
View viewOf(std::string_view json);

}  // namespace mote::test
