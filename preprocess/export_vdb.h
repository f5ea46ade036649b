// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a step of a dataset holds as an OpenVDB file, for any tool that reads these. One thread.
#pragma once

#include <filesystem>
#include <string>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::prep {

/// Writes what export_grids.h says of the dataset's kind, and returns what that is: "density" or "volume".
/// `output` appears by one rename. Errors: notFound,
/// corrupt, invalidArgument (there is no such step, or nothing of this kind to export), alreadyExists,
/// permissionDenied, resourceExhausted. Throws storage::StorageError where a volume is damaged.
Result<std::string> exportVdb(const std::filesystem::path& dataset, const proto::Manifest& manifest,
                              std::uint32_t step, const std::filesystem::path& output);

}  // namespace mote::prep
