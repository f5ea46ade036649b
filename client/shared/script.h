// SPDX-License-Identifier: GPL-3.0-or-later
//
// Reads a script. Everything that can be wrong in it by itself is found here, before a server is asked for
// anything. Pure, but for the file.
#pragma once

#include <filesystem>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::client {

/// A script that is valid in itself. Errors name the file and the field's path,
/// "views.json: views[2].layers[0].step": those of readJsonFile and checkScript.
Result<proto::Script> readScript(const std::filesystem::path& path);

}  // namespace mote::client
