// SPDX-License-Identifier: GPL-3.0-or-later
//
// JobOutput: where the output of a job request lies beneath the roots. A value; looking it up touches no
// file.
#pragma once

#include <filesystem>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "storage/roots.h"

namespace mote::server {

struct JobOutput {
    std::filesystem::path path;  ///< real, but for its last part
    std::filesystem::path root;  ///< the folder of its root
    bool exists = false;
};

/// Errors: invalidArgument, notFound (its root or its folder), permissionDenied.
Result<JobOutput> findOutput(const proto::JobRequest& request, const storage::Roots& roots);

/// Removes what a killed job left of it: unpublished drafts in its folder; how many there were.
std::size_t removeDrafts(const JobOutput& output);

}  // namespace mote::server
