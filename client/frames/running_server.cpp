// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/running_server.h"

namespace mote::client {

Result<std::unique_ptr<ServerLine>> runningServer(const FramesOptions& options, Wakeup& wakeup,
                                                  const Interrupt& interrupt) {
    MOTE_ASSIGN_OR_RETURN(auto server,
                          ServerLine::open("mote-frames", {options.connect.front()}, wakeup, interrupt));
    MOTE_RETURN_IF_ERROR(server->waitUntilConnected());
    return server;
}

}  // namespace mote::client
