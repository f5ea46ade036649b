// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a runner needs of the system that it is chosen on. A function that looks at files alone; any thread.
#pragma once

#include "protocol/scene/error.h"
#include "server/jobs/job_settings.h"

namespace mote::server {

/// Whether settings.runner is one, and its programs are in PATH. Errors: invalidArgument (there is no such
/// runner), notFound (the first program that is missing).
Status checkRunner(const JobSettings& settings);

}  // namespace mote::server
