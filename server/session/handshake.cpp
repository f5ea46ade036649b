// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/handshake.h"

#include <asio/co_spawn.hpp>
#include <utility>
#include <vector>

#include "protocol/wire/framing.h"
#include "server/session/outbox.h"

namespace mote::server {

Handshake::Handshake(wire::MessageStream stream, HandshakeTerms& terms)
    : terms_(terms), stream_(std::move(stream)), timer_(stream_.executor()) {}

void Handshake::start() {
    refuseAfter(terms_.timeout, {ErrorCode::cancelled, "hello", "the client did not say hello in time"});
    asio::co_spawn(
        timer_.get_executor(), [self = shared_from_this()] { return self->run(); },
        [self = shared_from_this()](const std::exception_ptr& failure) {
            if (failure) self->end();  // memory is short: this connection ends, the server goes on
        });
}

asio::awaitable<void> Handshake::run() {
    const auto version = co_await stream_.greet();
    if (ended_ || refusing_) co_return;
    if (!version.ok()) co_return co_await refuse(version.error());
    proto::ClientMessage message;
    std::vector<std::uint8_t> payload;
    const auto read = co_await stream_.read(message, payload, wire::helloLimits);
    if (ended_ || refusing_) co_return;
    if (!read.ok()) co_return co_await refuse(read.error());
    const auto role = message.has_hello() ? terms_.knows(message.hello().token()) : std::nullopt;
    if (!role) {
        co_return refuseAfter(terms_.wrongToken(),
                              {ErrorCode::permissionDenied, "hello.token",
                               "the token is not this server's; read its present connection file"});
    }
    const auto room = terms_.room(message.hello());
    if (!room.ok()) co_return co_await refuse(room.error());
    pass(std::move(message), *role);
}

/// In place of what the timer was set to before.
void Handshake::refuseAfter(std::chrono::milliseconds wait, Error reason) {
    timer_.expires_after(wait);
    timer_.async_wait([weak = weak_from_this(), reason = std::move(reason)](const asio::error_code& code) {
        const auto self = weak.lock();
        if (code || !self || self->ended_) return;
        if (self->refusing_) return self->end();
        asio::co_spawn(
            self->timer_.get_executor(), [self, reason] { return self->refuse(reason); },
            [self](const std::exception_ptr& failure) {
                if (failure) self->end();
            });
    });
}

asio::awaitable<void> Handshake::refuse(Error reason) {
    refusing_ = true;
    const bool gone = reason.code == ErrorCode::cancelled && reason.where == "connection";
    if (!gone && stream_.hasGreeted()) {
        refuseAfter(terms_.farewellTimeout, {});
        const auto said = co_await stream_.write(failureMessage(0, reason, true), {}, wire::serverLimits);
        if (said.ok() && !ended_) co_await stream_.finish();
    }
    end();
}

void Handshake::drop(const Error& reason) {
    if (!refusing_ && !ended_) stream_.turnAway(failureMessage(0, reason, true));
    end();
}

void Handshake::pass(proto::ClientMessage hello, Role role) {
    ended_ = true;
    timer_.cancel();
    const auto self = shared_from_this();
    terms_.ended(*this);
    terms_.passed(std::move(stream_), std::move(hello), role);
}

void Handshake::end() {
    if (std::exchange(ended_, true)) return;
    timer_.cancel();
    stream_.close();
    const auto self = shared_from_this();
    terms_.ended(*this);
}

}  // namespace mote::server
