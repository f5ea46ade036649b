// SPDX-License-Identifier: GPL-3.0-or-later
//
// Raw volumes: numbers without a header that says what they are; the job's options do. Called from one
// thread.
#pragma once

#include <filesystem>

#include "preprocess/volume/volume_source.h"

namespace mote::prep {

/// The file may be gzipped. Errors: invalidArgument (options that are missing or wrong), corrupt (another
/// length than the options say), those of fileStream.
Result<std::unique_ptr<VolumeSource>> openRaw(const proto::VolumeSourceOptions& options,
                                              const std::filesystem::path& path);

}  // namespace mote::prep
