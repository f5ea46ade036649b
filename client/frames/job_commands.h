// SPDX-License-Identifier: GPL-3.0-or-later
//
// What mote-frames does about the jobs of a running server, of whatever kind. Main thread.
#pragma once

#include "client/frames/options.h"
#include "client/shared/interrupt.h"
#include "protocol/scene/error.h"

namespace mote::client {

/// Does what a task of listJobs, follow, cancel or retry says. Errors: the server's (there is no such job, it
/// cannot be tried again), of follow why the job failed, internal (stdout), cancelled (interrupted).
Status runJobCommand(const FramesOptions& options, const Interrupt& interrupt);

}  // namespace mote::client
