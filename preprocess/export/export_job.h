// SPDX-License-Identifier: GPL-3.0-or-later
//
// The export job: particles of a dataset, all or a selection, as a file for other programs (openPMD with the
// beam physics extension). Called from one thread; uses as many as it may. The same dataset and request give
// the same bytes.
#pragma once

#include <filesystem>

#include "preprocess/job.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

/// Makes the file `output`, which appears by one rename, from the dataset in `dataset`. Errors:
/// invalidArgument (steps, the selection), unsupported (it holds no particles), notFound (it was made without
/// columns: says how to make them; a column, a step), corrupt, alreadyExists, permissionDenied,
/// resourceExhausted, cancelled.
Status exportParticles(const proto::ExportJob& job, const std::filesystem::path& dataset,
                       const std::filesystem::path& output, const JobResources& resources,
                       Progress& progress);

}  // namespace mote::prep
