// SPDX-License-Identifier: GPL-3.0-or-later
//
// The Communicator of processes that a launcher of MPI started: mpirun, srun. Called from main, once.
#pragma once

#include <functional>

#include "preprocess/parallel/communicator.h"

namespace mote::prep {

/// Whether the environment says that a launcher of MPI started this process and others with it. Touches no
/// MPI.
bool startedByMpi();

/// Joins the others; leaves them when it goes. Whoever waits for the others asks `cancelled` now and then.
/// Errors: internal (MPI does not start).
Result<std::unique_ptr<Communicator>> joinMpi(std::function<bool()> cancelled);

}  // namespace mote::prep
