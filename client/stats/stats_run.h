// SPDX-License-Identifier: GPL-3.0-or-later
//
// What mote-stats does: it asks a server for statistics or histograms and tells them. Main thread.
#pragma once

#include "client/shared/interrupt.h"
#include "client/stats/options.h"
#include "protocol/scene/error.h"

namespace mote::client {

/// Errors: of the options' files (the selection, the output), the server's (a dataset, a column, a step that
/// is not there), cancelled (interrupted; nothing half-written is left).
Status runStats(const StatsOptions& options, const Interrupt& interrupt);

}  // namespace mote::client
