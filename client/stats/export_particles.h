// SPDX-License-Identifier: GPL-3.0-or-later
//
// The particles of a selection as a file of the user's: openPMD as a job of the server's makes it, NumPy and
// text from columns that are asked for piece by piece. Main thread. A file appears whole; one of its name is
// replaced.
#pragma once

#include "client/stats/asked_run.h"
#include "client/stats/options.h"
#include "protocol/scene/error.h"

namespace mote::client {

/// By the ending of options.exported. Errors: the server's, notFound (the dataset was made without columns),
/// cancelled, those of the system.
Status exportParticles(const StatsOptions& options, AskedRun& run);

/// Of it, .npy and .csv: a row for each particle, with its step where there are several.
Status exportRows(const StatsOptions& options, AskedRun& run);

}  // namespace mote::client
