// SPDX-License-Identifier: GPL-3.0-or-later
//
// Jobs of a server, as its clients see them: the request that makes a film, what people know a job by, and
// how it stands. Pure functions.
#pragma once

#include <string>

#include "protocol/mote.pb.h"

namespace mote::client {

/// `video`: "mp4", "webm" or "gif"; "": its pictures alone. The script is a valid one.
proto::JobRequest filmRequest(const proto::Script& script, const std::string& video);

/// The catalogue's name of what a request makes: its output without ".mote".
std::string datasetName(const proto::JobRequest& request);
/// What people know a job by: the dataset that it makes, or its title.
std::string jobName(const proto::JobRequest& request);

/// "queued", "running", "succeeded", "failed" or "cancelled"; "unknown" for what only another server knows.
const char* stateName(proto::JobStatus::State state);
bool isUnderWay(const proto::JobStatus& job);
bool hasEnded(const proto::JobStatus& job);
/// What failed or was cancelled: the server makes a new job of it.
bool mayBeTriedAgain(const proto::JobStatus& job);
/// A film that is there to be fetched.
bool isReadyFilm(const proto::JobStatus& job);

}  // namespace mote::client
