// SPDX-License-Identifier: GPL-3.0-or-later
//
// The bridge from a browser's WebSocket to a connection to mote-server. Each binary message of the WebSocket
// is one frame of the protocol. The token of the server's never reaches the browser: it is put into the
// browser's hello here. The thread of the gateway.
#pragma once

#include <utility>  // Boost 1.74's awaitable.hpp does not include it

#include <boost/asio/awaitable.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "client/web/gateway/access.h"
#include "protocol/base/error.h"

namespace mote::web {

/// Awaits what puts its error there instead of throwing it.
inline auto into(boost::system::error_code& code) {
    return boost::asio::redirect_error(boost::asio::use_awaitable, code);
}

/// The bytes of one browser's connection, over TCP or a Unix socket, through TLS where a context is given: a
/// stream of Boost.Asio's, from which Beast reads HTTP and WebSockets.
class BrowserStream {
  public:
    using Plain = boost::beast::basic_stream<boost::asio::generic::stream_protocol>;
    using Tls = boost::beast::ssl_stream<Plain>;
    using executor_type = Plain::executor_type;

    /// `tls`: nothing, or what outlives the stream.
    BrowserStream(Plain::socket_type socket, boost::asio::ssl::context* tls)
        : stream_(std::in_place_type<Plain>, std::move(socket)) {
        if (tls == nullptr) return;
        Plain plain = std::get<Plain>(std::move(stream_));
        stream_.emplace<Tls>(std::move(plain), *tls);
    }

    executor_type get_executor() noexcept { return plain().get_executor(); }
    /// The socket with its patience.
    Plain& plain() {
        auto* const tls = std::get_if<Tls>(&stream_);
        return tls != nullptr ? tls->next_layer() : std::get<Plain>(stream_);
    }

    /// Before anything is read.
    boost::asio::awaitable<boost::system::error_code> shakeHands() {
        boost::system::error_code code;
        if (auto* const tls = std::get_if<Tls>(&stream_))
            co_await tls->async_handshake(boost::asio::ssl::stream_base::server, into(code));
        co_return code;
    }

    template <class Buffers, class Token>
    auto async_read_some(const Buffers& buffers, Token&& token) {
        return std::visit(
            [&](auto& stream) { return stream.async_read_some(buffers, std::forward<Token>(token)); },
            stream_);
    }
    template <class Buffers, class Token>
    auto async_write_some(const Buffers& buffers, Token&& token) {
        return std::visit(
            [&](auto& stream) { return stream.async_write_some(buffers, std::forward<Token>(token)); },
            stream_);
    }

    // What Beast's WebSocket ends a stream by.
    friend void beast_close_socket(BrowserStream& stream) { stream.plain().close(); }
    friend void teardown(boost::beast::role_type role, BrowserStream& stream,
                         boost::system::error_code& code) {
        using boost::beast::websocket::teardown;
        std::visit([&](auto& each) { teardown(role, each, code); }, stream.stream_);
    }
    template <class Handler>
    friend void async_teardown(boost::beast::role_type role, BrowserStream& stream, Handler&& handler) {
        using boost::beast::websocket::async_teardown;
        std::visit([&](auto& each) { async_teardown(role, each, std::forward<Handler>(handler)); },
                   stream.stream_);
    }

  private:
    std::variant<Plain, Tls> stream_;
};

using WebSocket = boost::beast::websocket::stream<BrowserStream>;

struct BridgeSettings {
    std::filesystem::path connectionFile;
    Role role = Role::nobody;
};

/// Pipes until either end ends. The WebSocket has been accepted; its last word says why it ends, where that
/// is not the browser's own wish: 1013 (the server is not there: try again), 1008 (what the browser sent is
/// not the protocol, or not allowed), 1011 (the server ended).
boost::asio::awaitable<void> runBridge(WebSocket& browser, BridgeSettings settings);

/// A message of a browser's as it goes on to the server: checked, and the first one with the server's token
/// in place of the browser's. Errors: corrupt (no whole frame of the protocol), permissionDenied (not for
/// this role), resourceExhausted (too long).
class FromBrowser {
  public:
    FromBrowser(Role role, std::string token) : role_(role), token_(std::move(token)) {}

    /// What is to be sent: valid until the next call, and `message` must be, too.
    Result<std::span<const std::uint8_t>> take(std::span<const std::uint8_t> message);

  private:
    Role role_;
    std::string token_;
    bool greeted_ = false;
    std::vector<std::uint8_t> rewritten_;
};

}  // namespace mote::web
