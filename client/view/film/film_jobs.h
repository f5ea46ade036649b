// SPDX-License-Identifier: GPL-3.0-or-later
//
// Films as jobs of the server: the request that makes one, and what a list calls it. Pure functions.
#pragma once

#include <string>

#include "protocol/mote.pb.h"

namespace mote::client {

/// `video`: "mp4", "webm" or "gif"; "": its pictures alone. The script is a valid one.
proto::JobRequest filmRequest(const proto::Script& script, const std::string& video);

/// What people know a job by: the dataset that it makes, or its title.
std::string jobName(const proto::JobRequest& request);

/// A film that is there to be fetched.
bool isReadyFilm(const proto::JobStatus& job);

}  // namespace mote::client
