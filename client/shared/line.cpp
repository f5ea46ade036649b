// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/connection_impl.h"

#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/error.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/local/stream_protocol.hpp>
#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>
#include <chrono>

#include "protocol/wire/framing.h"
#include "protocol/wire/tls.h"

namespace mote::client {
namespace {

constexpr std::chrono::seconds lastWords(1);

auto into(asio::error_code& code) {
    return asio::redirect_error(asio::use_awaitable, code);
}

Error noServer(const wire::Address& address, const asio::error_code& code) {
    if (code == asio::error::connection_refused || code == std::errc::no_such_file_or_directory) {
        return {ErrorCode::notFound, address.toString(), "no server listens here; is it still running?"};
    }
    const bool denied = code == asio::error::access_denied;
    return {denied ? ErrorCode::permissionDenied : ErrorCode::internal, address.toString(),
            "no connection to the server: " + code.message()};
}

/// The error of a stream that ended: to us its being closed is always the other side's doing.
Error lostServer(Error error) {
    if (error.code != ErrorCode::cancelled) return error;
    return {ErrorCode::internal, "", "the server closed the connection"};
}

}  // namespace

Line::Line(const asio::any_io_executor& executor, LineHandlers handlers)
    : handlers_(std::move(handlers)), stream_(wire::MessageStream::Socket(executor)), writerSleep_(executor) {
    writerSleep_.expires_at(asio::steady_timer::time_point::max());
}

void Line::open(const wire::Address& address, std::string fingerprint) {
    asio::co_spawn(
        writerSleep_.get_executor(),
        [self = shared_from_this(), address, fingerprint] { return self->run(address, fingerprint); },
        asio::detached);
}

void Line::wakeWriter() {
    writerSleep_.cancel();
}

void Line::close() {
    closed_ = true;
    stream_.close();
    writerSleep_.cancel();
}

void Line::fail(const Error& error) {
    if (closed_) return;
    close();
    handlers_.lost(error);
}

asio::awaitable<void> Line::run(wire::Address address, std::string fingerprint) {
    const bool tcp = address.kind == wire::Address::Kind::tcp;
    // In two statements: of what co_await gives within a choice, g++ 12 destroys the strings twice.
    Status connected = success();
    if (tcp) {
        connected = co_await connectTcp(address, std::move(fingerprint));
    } else {
        connected = co_await connectUnix(address);
    }
    if (!connected.ok()) co_return fail(connected.error());
    // The hello follows our greeting at once: on a slow line nobody waits for a round trip more.
    const std::function<void()> said = [self = shared_from_this()] {
        asio::co_spawn(
            self->writerSleep_.get_executor(), [self] { return self->writeAll(); }, asio::detached);
    };
    const auto version = co_await stream_.greet(wire::ownVersion, said);
    if (!version.ok()) co_return fail(lostServer(version.error()));
    co_await readAll();
}

asio::awaitable<Status> Line::connectUnix(const wire::Address& address) {
    asio::error_code code;
    const asio::local::stream_protocol::endpoint endpoint(address.path);  // its length has been checked
    co_await stream_.socket().async_connect(endpoint, into(code));
    if (code) co_return noServer(address, code);
    co_return success();
}

asio::awaitable<Status> Line::connectTcp(const wire::Address& address, std::string fingerprint) {
    asio::error_code code;
    asio::ip::tcp::resolver resolver(writerSleep_.get_executor());
    const auto port = std::to_string(address.port);
    const auto found = co_await resolver.async_resolve(address.host, port, into(code));
    if (code) co_return noServer(address, code);
    for (const auto& entry : found) {
        if (closed_) co_return noServer(address, asio::error::operation_aborted);
        stream_.close();
        co_await stream_.socket().async_connect(entry.endpoint(), into(code));
        if (!code) break;
    }
    if (code || closed_) co_return noServer(address, code);
    stream_.socket().set_option(asio::ip::tcp::no_delay(true), code);
    auto encrypted = wire::tlsClientStream(std::move(stream_.socket()), std::move(fingerprint));
    stream_ = wire::MessageStream(std::move(encrypted));
    co_return success();
}

asio::awaitable<void> Line::readAll() {
    while (!closed_) {
        proto::ServerMessage message;
        std::vector<std::uint8_t> payload;
        const auto read = co_await stream_.read(message, payload, wire::serverLimits);
        if (!read.ok()) co_return fail(lostServer(read.error()));
        if (!closed_) handlers_.received(std::move(message), std::move(payload));
    }
}

asio::awaitable<void> Line::writeAll() {
    while (!closed_) {
        if (const auto message = handlers_.next()) {
            const auto written = co_await stream_.write(*message, {}, wire::clientLimits);
            if (written.ok()) continue;
            // A server that closes has said why: what it sent is read first, and its end found there. One
            // that is silent, and reads no more, is not waited for longer.
            const auto end = std::chrono::steady_clock::now() + lastWords;
            while (!closed_ && std::chrono::steady_clock::now() < end) {
                asio::error_code woken;
                writerSleep_.expires_at(end);
                co_await writerSleep_.async_wait(into(woken));
            }
            co_return fail(lostServer(written.error()));
        } else {
            asio::error_code woken;
            co_await writerSleep_.async_wait(into(woken));
        }
    }
}

}  // namespace mote::client
