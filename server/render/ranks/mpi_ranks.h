// SPDX-License-Identifier: GPL-3.0-or-later
//
// The Ranks that a launcher of MPI started: mpirun, srun. Called from main, once.
#pragma once

#include <memory>

#include "server/render/ranks/ranks.h"

namespace mote::render {

/// Joins the others, and leaves them when it goes; null where this process was not started as one of several.
/// Touches no MPI where no launcher is about. Throws std::runtime_error where MPI does not start.
std::unique_ptr<Ranks> joinRanks();

}  // namespace mote::render
