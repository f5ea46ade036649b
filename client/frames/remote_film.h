// SPDX-License-Identifier: GPL-3.0-or-later
//
// Films that a server makes as jobs: left with it, and fetched. Main thread.
#pragma once

#include "client/frames/options.h"
#include "client/shared/interrupt.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::client {

/// Submits the script as a job and prints its id. Errors: the server's, among them what is wrong with the
/// script.
Status detachFilm(const FramesOptions& options, const proto::Script& script, const Interrupt& interrupt);

/// Brings what a job made: its video, a video of its pictures, or its pictures. Errors: the server's (there
/// is no such job, it is no film, it is not done), unsupported (it made nothing of that kind), the disk's.
Status fetchFilm(const FramesOptions& options, const Interrupt& interrupt);

}  // namespace mote::client
