// SPDX-License-Identifier: GPL-3.0-or-later
//
// Handshake: a connection that has not shown a token yet. One coroutine and one timer: TLS, the greetings and
// the hello have one deadline together. Owned by Startups and by its coroutine, by shared pointer; one
// thread.
#pragma once

#include <asio/awaitable.hpp>
#include <asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/wire/message_stream.h"
#include "server/session/role.h"

namespace mote::server {

class Handshake;

/// What all handshakes share; outlives them.
struct HandshakeTerms {
    std::chrono::milliseconds timeout{5000};          ///< from the connection to a good token
    std::chrono::milliseconds farewellTimeout{1000};  ///< a client has this long to take the last word
    /// Whose token it is; nothing where it is nobody's.
    std::function<std::optional<Role>(const std::string& token)> knows;
    /// Whether there is a place for a client that is known.
    std::function<Status(const proto::Hello& hello)> room;
    /// How long the answer to a wrong token waits.
    std::function<std::chrono::milliseconds()> wrongToken;
    /// Once, as the last thing: either the client is known, and the stream and its hello are handed on, or it
    /// was refused, or went away.
    std::function<void(wire::MessageStream stream, proto::ClientMessage hello, Role role)> passed;
    std::function<void(const Handshake& handshake)> ended;
};

class Handshake : public std::enable_shared_from_this<Handshake> {
  public:
    Handshake(wire::MessageStream stream, HandshakeTerms& terms);

    void start();
    /// Says why as far as that goes at once, and ends.
    void drop(const Error& reason);

  private:
    asio::awaitable<void> run();
    asio::awaitable<void> refuse(Error reason);
    void refuseAfter(std::chrono::milliseconds wait, Error reason);
    void pass(proto::ClientMessage hello, Role role);
    void end();

    HandshakeTerms& terms_;
    wire::MessageStream stream_;
    asio::steady_timer timer_;
    bool refusing_ = false;
    bool ended_ = false;
};

}  // namespace mote::server
