// SPDX-License-Identifier: GPL-3.0-or-later
//
// Whose a connection file is: a server neither takes a live one's nor removes another's. Pure, but for the
// file and the socket that it names.
#pragma once

#include <filesystem>
#include <string>

#include "protocol/scene/error.h"

namespace mote::server {

/// Errors: alreadyExists, where the file belongs to a server that accepts connections now.
Status checkNotInUse(const std::filesystem::path& file);

/// Removes the file if it holds this token, which is not empty then.
void removeIfOurs(const std::filesystem::path& file, const std::string& token);

}  // namespace mote::server
