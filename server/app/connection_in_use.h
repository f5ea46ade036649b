// SPDX-License-Identifier: GPL-3.0-or-later
//
// Whether a connection file belongs to a server that lives. Without state; waits for half a second at most.
#pragma once

#include <filesystem>

#include "protocol/scene/error.h"

namespace mote::server {

/// A server takes no live one's connection file. Errors: alreadyExists, where the file belongs to a server
/// that accepts connections now.
Status checkNotInUse(const std::filesystem::path& file);

}  // namespace mote::server
