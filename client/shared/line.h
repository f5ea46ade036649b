// SPDX-License-Identifier: GPL-3.0-or-later
//
// Line: one connected socket, from connect() to its end, never reused. It knows nothing of what messages
// mean. Owned by shared pointer, so that its coroutines outlive a close(); I/O thread only.
#pragma once

#include <asio/any_io_executor.hpp>
#include <asio/awaitable.hpp>
#include <asio/steady_timer.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "protocol/wire/address.h"
#include "protocol/wire/message_stream.h"

namespace mote::client {

/// What a line asks of its owner; called on the I/O thread, never after close().
struct LineHandlers {
    /// The next message to send; empty: nothing now. Asked only when the one before it is on its way, so that
    /// what is not asked for yet can still be replaced.
    std::function<std::optional<proto::ClientMessage>()> next;
    std::function<void(proto::ServerMessage, std::vector<std::uint8_t> payload)> received;
    /// There is no server, or the line is closed by it or broken; once.
    std::function<void(Error)> lost;
};

class Line : public std::enable_shared_from_this<Line> {
  public:
    Line(const asio::any_io_executor& executor, LineHandlers handlers);

    /// Connects to a server's socket and greets; then reads and writes until close() or lost.
    void open(const wire::Address& address);
    /// next() has something.
    void wakeWriter();
    void close();

  private:
    asio::awaitable<void> run(wire::Address address);
    asio::awaitable<Status> connect(const wire::Address& address);
    asio::awaitable<void> readAll();
    asio::awaitable<void> writeAll();
    void fail(const Error& error);

    LineHandlers handlers_;
    wire::MessageStream stream_;
    asio::steady_timer writerSleep_;
    bool closed_ = false;
};

}  // namespace mote::client
