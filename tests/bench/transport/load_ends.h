// SPDX-License-Identifier: GPL-3.0-or-later
//
// The two ends of a load of pictures, over the wire code of server and clients: one sends payloads at a
// fixed rate on many connections, the other says how late each arrives. Each blocks the thread that calls it.
#pragma once

#include <asio/io_context.hpp>
#include <chrono>
#include <cstddef>
#include <functional>
#include <vector>

#include "protocol/wire/message_stream.h"

namespace mote::test {

struct Load {
    std::int64_t clients = 32;
    double rate = 30.0;            ///< payloads a second and client
    std::int64_t payload = 65536;  ///< bytes
    double seconds = 20.0;
};

/// Opens a connection of one end; may block.
using Opener = std::function<wire::MessageStream(asio::io_context&)>;

/// What one end says of itself: its memory a fifth of the way through and at the end.
struct Growth {
    double earlyMiB = 0.0, lateMiB = 0.0;
};

/// Opens all connections, then sends on each at the rate, all out of step. Each message says when it was due.
Growth sendLoad(const Load& load, const Opener& accept);

/// Opens all connections and reads them to their end. `delays`: from when each payload was due until all of
/// it was there, ms.
Growth receiveLoad(const Load& load, const Opener& connect, std::vector<double>& delays);

}  // namespace mote::test
