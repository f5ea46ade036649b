// SPDX-License-Identifier: GPL-3.0-or-later
//
// The line to a running server, whose jobs are wanted. Main thread.
#pragma once

#include <memory>

#include "client/frames/options.h"
#include "client/shared/interrupt.h"
#include "client/shared/server_line.h"
#include "client/shared/wakeup.h"
#include "protocol/scene/error.h"

namespace mote::client {

/// The first running server of the options, which has welcomed us. Errors: as ServerLine::waitUntilConnected.
Result<std::unique_ptr<ServerLine>> runningServer(const FramesOptions& options, Wakeup& wakeup,
                                                  const Interrupt& interrupt);

}  // namespace mote::client
