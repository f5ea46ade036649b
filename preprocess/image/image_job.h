// SPDX-License-Identifier: GPL-3.0-or-later
//
// The image job: from a picture file to a dataset of kind "image". Called from one thread. The same file
// gives the same bytes.
#pragma once

#include <filesystem>

#include "preprocess/job.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

/// Makes `output`, which appears by one rename, from `input`. Returns its manifest. Errors: alreadyExists,
/// permissionDenied, resourceExhausted, cancelled, and readPicture's.
Result<proto::Manifest> runImageJob(const proto::JobRequest& request, const std::filesystem::path& input,
                                    const std::filesystem::path& output, const JobResources& resources,
                                    Progress& progress);

}  // namespace mote::prep
