// SPDX-License-Identifier: GPL-3.0-or-later
//
// MessageStream: messages over a connected socket, as Asio coroutines. Owned by one end of a connection, used
// on the thread of its executor; one read and one write may be under way at a time. Nothing here throws for
// what the other side does. A stream that returned an error is of no further use but to be closed (exception:
// a message that is too long to be written left the stream as it was).
//
// Errors of every coroutine here: cancelled where the connection ended, by either side's closing it; internal
// where the system broke it; corrupt, unsupported or resourceExhausted where the other side sends what the
// protocol does not allow.
#pragma once

#include <google/protobuf/message_lite.h>

#include <asio/awaitable.hpp>
#include <asio/generic/stream_protocol.hpp>
#include <cstdint>
#include <span>
#include <vector>

#include "protocol/scene/error.h"
#include "protocol/wire/framing.h"

namespace mote::wire {

class MessageStream {
  public:
    /// Unix or TCP: asio::local::stream_protocol::socket and asio::ip::tcp::socket convert to it.
    using Socket = asio::generic::stream_protocol::socket;

    explicit MessageStream(Socket socket) : socket_(std::move(socket)) {}

    Socket& socket() { return socket_; }

    /// Sends our greeting, then waits for theirs; returns their version. Both sides do this first.
    asio::awaitable<Result<Version>> greet(Version own = ownVersion);

    /// Reads one frame. `payload` keeps its capacity; it is empty where the frame has none.
    asio::awaitable<Status> read(google::protobuf::MessageLite& message, std::vector<std::uint8_t>& payload,
                                 FrameLimits limits);

    /// Writes one frame; `payload` goes to the kernel from where it lies and must stay there until the end.
    /// resourceExhausted: too long, nothing was written.
    asio::awaitable<Status> write(const google::protobuf::MessageLite& message,
                                  std::span<const std::uint8_t> payload, FrameLimits limits);

    /// Ends what is under way (cancelled) and the connection. May be called again.
    void close();

  private:
    Socket socket_;
    std::vector<std::uint8_t> readBuffer_;   ///< of the message under way
    std::vector<std::uint8_t> writeBuffer_;  ///< header and message under way
};

}  // namespace mote::wire
