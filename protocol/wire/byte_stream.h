// SPDX-License-Identifier: GPL-3.0-or-later
//
// ByteStream: the bytes of one connection, as they are on a Unix socket; TlsStream encrypts them. Owned by a
// MessageStream, used on the thread of its socket's executor; one read and one write may be under way at a
// time. Nothing here throws for what the other side does.
#pragma once

#include <array>
#include <asio/awaitable.hpp>
#include <asio/buffer.hpp>
#include <asio/generic/stream_protocol.hpp>
#include <cstdint>
#include <span>

#include "protocol/base/error.h"

namespace mote::wire {

/// cancelled ("connection") where either side closed it, internal where the system broke it.
Error connectionError(const asio::error_code& code);

class ByteStream {
  public:
    /// Unix or TCP: asio::local::stream_protocol::socket and asio::ip::tcp::socket convert to it.
    using Socket = asio::generic::stream_protocol::socket;
    /// Parts that lie in different places and follow each other on the wire.
    using ToRead = std::array<asio::mutable_buffer, 2>;
    using ToWrite = std::array<asio::const_buffer, 2>;

    explicit ByteStream(Socket socket) : socket_(std::move(socket)) {}
    virtual ~ByteStream() = default;
    ByteStream(const ByteStream&) = delete;
    ByteStream& operator=(const ByteStream&) = delete;

    Socket& socket() { return socket_; }

    /// What both sides do before the first byte; nothing here. Errors: cancelled ("connection") where the
    /// other side is not one of ours or went away.
    virtual asio::awaitable<Status> shakeHands();
    /// All of it, or an error. asio::error::eof where the other side ended, however it did.
    virtual asio::awaitable<asio::error_code> read(ToRead parts);
    virtual asio::awaitable<asio::error_code> write(ToWrite parts);
    /// As much of it as goes out at once; no write is under way.
    virtual void tryWrite(std::span<const std::uint8_t> bytes);

    /// Grows with each byte that comes, and with those that go while others of the same write wait for them:
    /// the signs that the other side is there. What goes at once says nothing, as the system takes it from
    /// us.
    std::uint64_t progress() const { return progress_; }

  protected:
    /// asio::transfer_all that counts progress; of one read, of which `done` have come. It is not asked about
    /// the last piece.
    auto countRead(std::size_t& done) {
        return [this, &done](const asio::error_code& code, std::size_t now) {
            countRead(done, now);
            return code ? std::size_t{0} : mostAtOnce;
        };
    }
    void countRead(std::size_t& done, std::size_t now) {
        progress_ += now - done;
        done = now;
    }
    /// Of one write of so many bytes.
    auto countWritten(std::size_t size) {
        return [this, size, done = std::size_t{0}](const asio::error_code& code, std::size_t now) mutable {
            if (now < size) progress_ += now - done;
            done = now;
            return code ? std::size_t{0} : mostAtOnce;
        };
    }

  private:
    static constexpr std::size_t mostAtOnce = 65536;  ///< as asio::transfer_all has it

    Socket socket_;
    std::uint64_t progress_ = 0;
};

}  // namespace mote::wire
