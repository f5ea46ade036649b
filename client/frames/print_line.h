// SPDX-License-Identifier: GPL-3.0-or-later
//
// What mote-frames says on stdout. Main thread.
#pragma once

#include <string>

#include "protocol/scene/error.h"

namespace mote::client {

/// Puts text on stdout at once. Errors: internal (nobody reads it any more, the disk is full).
Status print(const std::string& text);

}  // namespace mote::client
