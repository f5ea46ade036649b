// SPDX-License-Identifier: GPL-3.0-or-later
//
// Listener: accepts connections on one Unix socket or TCP port. Whatever goes wrong with one of them, it
// accepts the next; where the process has no descriptor left, who comes is told so. Owned by the server, on
// the thread of its io_context.
#pragma once

#include <asio/basic_socket_acceptor.hpp>
#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>
#include <functional>

#include "protocol/base/error.h"
#include "protocol/wire/address.h"
#include "protocol/wire/byte_stream.h"
#include "storage/files/file_descriptor.h"

namespace mote::server {

/// Errors: notFound (no such host).
Result<wire::ByteStream::Socket::endpoint_type> endpointOf(asio::io_context& io,
                                                           const wire::Address& address);

class Listener {
  public:
    using Socket = wire::ByteStream::Socket;

    struct Events {
        /// A connection. May throw: it is closed then.
        std::function<void(Socket)> accepted;
        /// A connection that there is no descriptor for; to be told so at once, and closed.
        std::function<void(Socket)> refused;
        /// Whether the next one waits for a moment: a bound of what strangers cost.
        std::function<bool()> crowded;
    };

    Listener(asio::io_context& io, Events events);

    /// A Unix socket is never there for others, not even between two calls. A TCP port of 0 is chosen by the
    /// kernel. May be called again where it failed. Errors: internal, notFound (no such host).
    Status listen(const wire::Address& address);
    /// After listen(): with the port that it has.
    const wire::Address& address() const { return address_; }

    /// Accepts from now on. Changes nothing where it does.
    void accept();
    void close();

  private:
    void take(const asio::error_code& code, Socket socket);
    void refuseAll();
    void acceptAfter(std::chrono::milliseconds pause);

    Events events_;
    wire::Address address_;
    asio::basic_socket_acceptor<Socket::protocol_type> acceptor_;
    asio::steady_timer pause_;
    storage::FileDescriptor spare_;  // to take those with for whom there is no other
    bool waiting_ = false;           // for a connection, or for the pause to end
    bool closed_ = false;
};

}  // namespace mote::server
