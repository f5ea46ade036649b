// SPDX-License-Identifier: GPL-3.0-or-later
//
// runThrough: an io_context that goes on where a handler throws, as all do where memory is short. What was
// being done then is lost, the program is not. Called by the server, on its thread.
#pragma once

#include <asio/io_context.hpp>
#include <functional>

namespace mote::server {

/// Calls `prepare`, which begins what the context waits for, and runs the context until it is stopped or
/// nothing is left to wait for. Where either throws, both are tried anew after a pause: `prepare` can be
/// called again, as what threw may have been about to begin something. Returns instead where `over` says that
/// it is time: where memory does not come back, say. `over` throws nothing.
void runThrough(asio::io_context& io, const std::function<void()>& prepare,
                const std::function<bool()>& over);

}  // namespace mote::server
