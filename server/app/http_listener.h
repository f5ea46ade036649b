// SPDX-License-Identifier: GPL-3.0-or-later
//
// HttpListener: answers requests for metrics on a Unix socket or on the loopback device, beside the server's
// own socket. It tells nothing that is secret, and takes little: few connections at once, each for a short
// time and a short request. Owned by the server; all on the thread of its io_context.
#pragma once

#include <asio/basic_socket_acceptor.hpp>
#include <asio/generic/stream_protocol.hpp>
#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "protocol/base/error.h"
#include "protocol/wire/address.h"
#include "server/metrics/http_answer.h"

namespace mote::server {

class HttpListener {
  public:
    /// "unix:PATH" or "127.0.0.1:PORT" ("[::1]:PORT"); port 0 is one that is free. Errors: invalidArgument
    /// (anything else), alreadyExists (somebody listens there), internal.
    static Result<std::unique_ptr<HttpListener>> open(asio::io_context& context, const std::string& address,
                                                      HttpPages pages);
    /// Errors: invalidArgument (it is no such address).
    static Result<wire::Address> parse(const std::string& address);
    /// Removes its socket. Connections that are open end with the io_context.
    ~HttpListener();
    HttpListener(const HttpListener&) = delete;
    HttpListener& operator=(const HttpListener&) = delete;

    /// With the port that was found.
    const std::string& address() const { return address_; }

  private:
    using Protocol = asio::generic::stream_protocol;
    using Acceptor = asio::basic_socket_acceptor<Protocol>;

    HttpListener(asio::io_context& context, HttpPages pages);
    Status listen(const std::string& address);
    Status listenAt(const Protocol::endpoint& endpoint, int family);
    void accept();
    void acceptLater();

    asio::io_context& context_;
    const std::shared_ptr<const HttpPages> pages_;
    Acceptor acceptor_;
    asio::steady_timer pause_;
    std::string address_;
    std::filesystem::path socket_;                                           // to be removed; or empty
    std::shared_ptr<unsigned> connections_ = std::make_shared<unsigned>(0);  // open now
};

}  // namespace mote::server
