// SPDX-License-Identifier: GPL-3.0-or-later
//
// ConnectionTest: a Connection and the FakeServer at its other end, and what their tests ask again and again.
// One thread, the test's.
#pragma once

#include <gtest/gtest.h>

#include <optional>

#include "client/shared/connection.h"
#include "tests/unit/client/fake_server.h"
#include "tests/unit/client/frames.h"

namespace mote::client {

using test::FakeServer;

/// No pings but those that a test asks for; a line that breaks is lost.
inline ConnectionSettings quietSettings() {
    ConnectionSettings settings;
    settings.client = "connection test";
    settings.pingInterval = std::chrono::milliseconds(0);
    settings.returnPatience = std::chrono::milliseconds(0);
    return settings;
}

/// Polls until it holds; false after 20 s.
template <class Condition>
bool eventually(Connection& connection, const Condition& condition) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (std::chrono::steady_clock::now() < end) {
        connection.poll();
        if (condition()) return true;
        connection.wait(std::chrono::milliseconds(20));
    }
    return false;
}

/// The newest frame, once there is one.
inline ReceivedFrame frameOf(Connection& connection) {
    std::optional<ReceivedFrame> frame;
    EXPECT_TRUE(eventually(connection, [&] { return (frame = connection.takeFrame()).has_value(); }));
    return frame.value_or(ReceivedFrame{});
}

inline proto::View viewOfWidth(std::uint32_t width) {
    proto::View view;
    view.set_width(width);
    view.set_height(4);
    return view;
}

class ConnectionTest : public testing::Test {
  protected:
    using State = Connection::State;

    void connect(const ConnectionSettings& settings = quietSettings(), std::uint32_t minor = 0) {
        connection_.emplace(server_.connectionFile(), settings);
        server_.welcome(minor);
        ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::connected; }));
    }

    void sendFrame(std::uint64_t viewId, std::uint32_t width) {
        const auto pixels = test::samplePixels(width, 4, proto::SRGB8);
        proto::ServerMessage message;
        *message.mutable_frame() = test::frameMessage(width, 4, proto::SRGB8, proto::Frame::ZSTD);
        message.mutable_frame()->set_view_id(viewId);
        server_.send(message, test::zstdPayload(pixels, width, proto::SRGB8));
    }

    /// Waits until the connection has read everything that was sent so far.
    void settle() {
        bool answered = false;
        connection_->ping([&](const Result<double>&) { answered = true; });
        const auto ping = server_.read(proto::ClientMessage::kPing);
        proto::ServerMessage pong;
        pong.set_reply_to(ping.request());
        pong.mutable_pong()->set_sent_ns(ping.ping().sent_ns());
        server_.send(pong);
        ASSERT_TRUE(eventually(*connection_, [&] { return answered; }));
    }

    FakeServer server_;
    std::optional<Connection> connection_;
};

}  // namespace mote::client
