// SPDX-License-Identifier: GPL-3.0-or-later
//
// MessageStream: messages over a connection, as Asio coroutines. Owned by one end of a connection, used on
// the thread of its executor; one read and one write may be under way at a time. Nothing here throws for
// what the other side does. A stream that returned an error is of no further use but to be closed (exception:
// a message that is too long to be written left the stream as it was).
//
// Errors of every coroutine here: cancelled where the connection ended, by either side's closing it; internal
// where the system broke it; corrupt, unsupported or resourceExhausted where the other side sends what the
// protocol does not allow.
#pragma once

#include <google/protobuf/message_lite.h>

#include <asio/awaitable.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/wire/byte_stream.h"
#include "protocol/wire/framing.h"

namespace mote::wire {

class MessageStream {
  public:
    using Socket = ByteStream::Socket;

    explicit MessageStream(Socket socket) : bytes_(std::make_unique<ByteStream>(std::move(socket))) {}
    explicit MessageStream(std::unique_ptr<ByteStream> bytes) : bytes_(std::move(bytes)) {}

    Socket& socket() { return bytes_->socket(); }
    Socket::executor_type executor() { return socket().get_executor(); }

    /// Shakes hands, sends our greeting, then waits for theirs; returns their version. Both sides do this
    /// first. `said` is called when ours is out: who then writes saves the round trip to theirs.
    asio::awaitable<Result<Version>> greet(Version own = ownVersion, std::function<void()> said = {});
    /// Whether our greeting is out: a message can follow.
    bool hasGreeted() const { return greeted_; }

    /// As ByteStream::progress().
    std::uint64_t progress() const { return bytes_->progress(); }

    /// Reads one frame. `payload` keeps its capacity; it is empty where the frame has none.
    asio::awaitable<Status> read(google::protobuf::MessageLite& message, std::vector<std::uint8_t>& payload,
                                 FrameLimits limits);

    /// Writes one frame; `payload` goes to the kernel from where it lies and must stay there until the end.
    /// resourceExhausted: too long, nothing was written.
    asio::awaitable<Status> write(const google::protobuf::MessageLite& message,
                                  std::span<const std::uint8_t> payload, FrameLimits limits);

    /// Says a last word as far as it can be said at once, and closes. No write is under way.
    void turnAway(const google::protobuf::MessageLite& message);

    /// After the last message: waits until the other side has ended too, or close(). What it still sends is
    /// thrown away; the system would else take back what it has not read yet.
    asio::awaitable<void> finish();

    /// Ends what is under way (cancelled) and the connection. May be called again.
    void close();

  private:
    std::unique_ptr<ByteStream> bytes_;
    bool greeted_ = false;
    std::vector<std::uint8_t> readBuffer_;   ///< of the message under way
    std::vector<std::uint8_t> writeBuffer_;  ///< header and message under way
};

}  // namespace mote::wire
