// SPDX-License-Identifier: GPL-3.0-or-later
//
// Reads a script of views. Everything that can be wrong in it by itself is found here, before a server is
// asked for anything. Pure, but for the file.
#pragma once

#include <filesystem>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::client {

/// A script of more views than this is taken for a mistake; pictures are numbered with six digits.
inline constexpr int maxViews = 1000000;

/// The views of a script, at least one, each valid in itself. Errors name the file and the field's path,
/// "views.json: views[2].layers[0].step": those of readJsonFile and parseView, unsupported (keyframes).
Result<std::vector<proto::View>> readScript(const std::filesystem::path& path);

/// Whether the server has every dataset and step that the views show. Errors: notFound and invalidArgument
/// with the field's path.
Status checkDatasets(const std::vector<proto::View>& views, const proto::Catalogue& catalogue);

}  // namespace mote::client
