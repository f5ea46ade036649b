// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where pictures go that a person should look at: the folder golden/ of the build. Pure, but for the files.
#pragma once

#include <string>

#include "tests/support/image.h"

namespace mote::test {

/// golden/NAME.png, replaced; a failure is a test failure.
void keep(const Image& image, const std::string& name);

/// Whether MOTE_GOLDEN_KEEP is set: every picture is then kept, not only those that fail.
bool keepAll();

}  // namespace mote::test
