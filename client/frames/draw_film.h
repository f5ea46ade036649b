// SPDX-License-Identifier: GPL-3.0-or-later
//
// Draws a script, from servers to files. Main thread.
#pragma once

#include "client/frames/options.h"
#include "client/shared/interrupt.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::client {

/// `script`: checked by itself; `name`: what errors call it. Finished pictures stay whatever happens. Errors:
/// the script's with its datasets, the servers', the disk's, cancelled (interrupted).
Status drawFilm(const FramesOptions& options, const proto::Script& script, const std::string& name,
                const Interrupt& interrupt);

/// As a job: what its request asks for, into the folder `film` beside the request's file; what is there
/// already stays, and a server that ends is waited for.
Status drawFilmJob(const FramesOptions& options, const Interrupt& interrupt);

}  // namespace mote::client
