// SPDX-License-Identifier: GPL-3.0-or-later
//
// Replot: the request that made a dataset, as a client may submit it again. Asks the file system; any thread.
#pragma once

#include <filesystem>
#include <optional>

#include "protocol/mote.pb.h"
#include "storage/roots.h"

namespace mote::server {

/// `request` is that of the manifest, its inputs relative to `folder`, which holds the dataset. The result
/// names inputs "ROOT/PATH" and has no output. Nothing where an input is no longer there or lies beneath no
/// root, or where the request has no inputs.
std::optional<proto::JobRequest> replotOf(const proto::JobRequest& request,
                                          const std::filesystem::path& folder, const storage::Roots& roots);

}  // namespace mote::server
