// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a server keeps for itself alone: names of programs that it runs, of folders that it removes. Files
// that somebody else made, or may write to, are not taken for its own. Free functions, any thread.
#pragma once

#include <filesystem>

#include "protocol/scene/error.h"

namespace mote::server {

/// Makes the folder (0700), or takes one that is there: of this user, no link, for nobody else to write to.
/// Errors: permissionDenied, saying what is wrong with it.
Status makeOwnFolder(const std::filesystem::path& folder);

/// One that is there, likewise.
Status checkOwnFolder(const std::filesystem::path& folder);

/// A file that is there must be a regular one, of this user and for nobody else to write to; none is well.
/// Errors: permissionDenied.
Status checkOwnFile(const std::filesystem::path& file);

}  // namespace mote::server
