// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a step of a dataset holds as an OpenVDB file, for any tool that reads these. One thread.
#pragma once

#include <filesystem>
#include <string>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

/// Particles become a fog volume "density" in layer space; axes and bounds are metadata. A hybrid volume
/// becomes, in the source's unit and world, "volume", all samples of the low-resolution volume, and where
/// there is one "residual", what is to be added to it, interpolated linearly, at the samples of the error
/// grid. `output` appears by one rename. Returns which: "density" or "volume". Errors: notFound, corrupt,
/// invalidArgument (there is no such step, or nothing of this kind to export), alreadyExists,
/// permissionDenied, resourceExhausted. Throws storage::StorageError if a volume is damaged.
Result<std::string> exportVdb(const std::filesystem::path& dataset, const proto::Manifest& manifest,
                              std::uint32_t step, const std::filesystem::path& output);

}  // namespace mote::prep
