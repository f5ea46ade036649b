// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/web/gateway/bridge.h"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "protocol/base/complain.h"
#include "protocol/mote.pb.h"
#include "protocol/wire/address.h"
#include "protocol/wire/connection_file.h"
#include "protocol/wire/framing.h"

namespace mote::web {
namespace {

namespace net = boost::asio;
namespace websocket = boost::beast::websocket;
using boost::system::error_code;

/// What is held of a message on its way to a browser, bytes.
constexpr std::size_t pieceSize = std::size_t{256} << 10;
/// The most that a close frame says, bytes.
constexpr std::size_t mostReason = 120;
constexpr const char* serverEnded = "the server ended the connection";

/// The line to the server: a Unix socket, or TLS over TCP. The certificate is the one whose fingerprint the
/// connection file says, whoever signed it.
class ServerStream {
  public:
    explicit ServerStream(const net::any_io_executor& executor)
        : socket_(executor), tcp_(executor, context_) {}

    net::awaitable<error_code> connect(const wire::Address& address, const std::string& fingerprint) {
        error_code code;
        if (address.kind == wire::Address::Kind::unixSocket) {
            co_await socket_.async_connect(net::local::stream_protocol::endpoint(address.path), into(code));
            co_return code;
        }
        encrypted_ = true;
        net::ip::tcp::resolver resolver(socket_.get_executor());
        const auto found =
            co_await resolver.async_resolve(address.host, std::to_string(address.port), into(code));
        if (!code) co_await net::async_connect(tcp_.lowest_layer(), found, into(code));
        if (code) co_return code;
        tcp_.lowest_layer().set_option(net::ip::tcp::no_delay(true), code);
        tcp_.set_verify_mode(net::ssl::verify_peer);
        tcp_.set_verify_callback([fingerprint](bool, net::ssl::verify_context& context) {
            return isExpected(context, fingerprint);
        });
        co_await tcp_.async_handshake(net::ssl::stream_base::client, into(code));
        co_return code;
    }

    net::awaitable<error_code> read(std::span<std::uint8_t> room) {
        error_code code;
        const auto buffer = net::buffer(room.data(), room.size());
        if (encrypted_) {
            co_await net::async_read(tcp_, buffer, into(code));
        } else {
            co_await net::async_read(socket_, buffer, into(code));
        }
        co_return code;
    }

    net::awaitable<error_code> write(std::span<const std::uint8_t> bytes) {
        error_code code;
        const auto buffer = net::buffer(bytes.data(), bytes.size());
        if (encrypted_) {
            co_await net::async_write(tcp_, buffer, into(code));
        } else {
            co_await net::async_write(socket_, buffer, into(code));
        }
        co_return code;
    }

    void close() {
        error_code ignored;
        socket_.close(ignored);
        tcp_.lowest_layer().close(ignored);
    }

  private:
    static bool isExpected(net::ssl::verify_context& context, const std::string& fingerprint) {
        auto* const certificate = X509_STORE_CTX_get0_cert(context.native_handle());
        std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
        unsigned size = 0;
        if (certificate == nullptr || X509_digest(certificate, EVP_sha256(), digest.data(), &size) != 1)
            return false;
        std::string text;
        for (unsigned i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
        return !fingerprint.empty() && text == fingerprint;
    }

    net::local::stream_protocol::socket socket_;
    net::ssl::context context_{net::ssl::context::tlsv13_client};
    net::ssl::stream<net::ip::tcp::socket> tcp_;
    bool encrypted_ = false;
};

/// Both directions of one bridge; it lives as long as either.
class Pipes : public std::enable_shared_from_this<Pipes> {
  public:
    Pipes(WebSocket& browser, BridgeSettings settings)
        : browser_(browser),
          settings_(std::move(settings)),
          server_(browser.get_executor()),
          ended_(browser.get_executor(), net::steady_timer::time_point::max()) {}

    net::awaitable<void> run() {
        const auto opened = co_await open();
        if (!opened.ok()) {
            complain("mote-web", opened.error().toString());
            ends(websocket::close_code::try_again_later, "the server is not there");
            co_await farewell();
            co_return;
        }
        reading_ = true;
        net::co_spawn(
            browser_.get_executor(), [self = shared_from_this()] { return self->up(); }, net::detached);
        co_await down();
        server_.close();
        co_await farewell();
        // What the browser still sends is read by nobody.
        browser_.next_layer().plain().close();
        while (reading_) {
            error_code code;
            co_await ended_.async_wait(into(code));
        }
    }

  private:
    net::awaitable<Status> open() {
        const auto file = wire::readConnectionFile(settings_.connectionFile);
        if (!file.ok()) co_return file.error();
        const auto address = wire::parseAddress(file->address());
        if (!address.ok()) co_return address.error();
        from_ = std::make_unique<FromBrowser>(settings_.role, file->token());
        if (const auto code = co_await server_.connect(*address, file->certificate_fingerprint()))
            co_return notFound(file->address(), "mote-server does not answer: " + code.message());
        auto greeting = wire::encodeGreeting(wire::ownVersion);
        auto code = co_await server_.write(greeting);
        if (!code) code = co_await server_.read(greeting);
        if (code) co_return notFound(file->address(), "mote-server ended: " + code.message());
        const auto version = wire::decodeGreeting(greeting);
        if (!version.ok()) co_return version.error();
        co_return success();
    }

    /// From the server to the browser.
    net::awaitable<void> down() {
        piece_.resize(pieceSize);
        while (true) {
            wire::Header header;
            if (co_await server_.read(header))
                co_return ends(websocket::close_code::internal_error, serverEnded);
            const auto sizes = wire::decodeHeader(header, wire::serverLimits);
            if (!sizes.ok()) co_return ends(websocket::close_code::internal_error, sizes.error().toString());
            std::ranges::copy(header, piece_.begin());
            std::size_t held = header.size();
            std::size_t left = std::size_t{sizes->message} + sizes->payload;
            do {
                const auto part = std::min(left, pieceSize - held);
                if (part > 0 && co_await server_.read(std::span(piece_).subspan(held, part)))
                    co_return ends(websocket::close_code::internal_error, serverEnded);
                left -= part;
                error_code code;
                co_await browser_.async_write_some(left == 0, net::buffer(piece_.data(), held + part),
                                                   into(code));
                if (code) co_return;
                held = 0;
            } while (left > 0);
        }
    }

    /// From the browser to the server.
    net::awaitable<void> up() {
        boost::beast::flat_buffer buffer(wire::clientLimits.message + sizeof(wire::Header));
        while (true) {
            error_code code;
            buffer.clear();
            co_await browser_.async_read(buffer, into(code));
            if (code) break;
            if (!browser_.got_binary()) continue;
            const auto bytes = buffer.cdata();
            const auto checked = from_->take({static_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
            if (!checked.ok()) {
                ends(websocket::close_code::policy_error, checked.error().toString());
                break;
            }
            if (co_await server_.write(*checked)) break;
        }
        reading_ = false;
        server_.close();
        ended_.cancel();
    }

    /// The first reason counts. (Not given in braces to a coroutine: g++ 12 frees such a value twice.)
    void ends(websocket::close_code code, std::string reason) {
        if (why_ != websocket::close_code::normal) return;
        why_ = code;
        reason_ = reason.substr(0, mostReason);
    }

    net::awaitable<void> farewell() {
        if (!browser_.is_open() || why_ == websocket::close_code::normal) co_return;
        error_code code;
        const websocket::close_reason word(why_, reason_);
        co_await browser_.async_close(word, into(code));
    }

    WebSocket& browser_;
    BridgeSettings settings_;
    ServerStream server_;
    std::unique_ptr<FromBrowser> from_;
    std::vector<std::uint8_t> piece_;
    net::steady_timer ended_;
    bool reading_ = false;
    websocket::close_code why_ = websocket::close_code::normal;
    std::string reason_;
};

}  // namespace

Result<std::span<const std::uint8_t>> FromBrowser::take(std::span<const std::uint8_t> message) {
    wire::Header header;
    if (message.size() < header.size()) return corrupt("message", "is shorter than a header");
    std::ranges::copy(message.first(header.size()), header.begin());
    MOTE_ASSIGN_OR_RETURN(const auto sizes,
                          wire::decodeHeader(header, greeted_ ? wire::clientLimits : wire::helloLimits));
    const auto body = message.subspan(header.size());
    if (body.size() != sizes.message) return corrupt("message", "is not as long as its header says");
    if (greeted_ && role_ == Role::owner) return message;
    proto::ClientMessage parsed;
    MOTE_RETURN_IF_ERROR(wire::decodeMessage(body, parsed));
    MOTE_RETURN_IF_ERROR(Access::mayAsk(role_, parsed));
    if (greeted_) return message;
    if (!parsed.has_hello()) return corrupt("message", "the first one is no hello");
    parsed.mutable_hello()->set_token(token_);
    MOTE_RETURN_IF_ERROR(wire::encodeFrame(parsed, 0, wire::helloLimits, rewritten_));
    greeted_ = true;
    return std::span<const std::uint8_t>(rewritten_);
}

net::awaitable<void> runBridge(WebSocket& browser, BridgeSettings settings) {
    const auto pipes = std::make_shared<Pipes>(browser, std::move(settings));
    co_await pipes->run();
}

}  // namespace mote::web
