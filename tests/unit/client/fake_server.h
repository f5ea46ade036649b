// SPDX-License-Identifier: GPL-3.0-or-later
//
// FakeServer: the other end of a Connection, moved by the test step by step on its own thread: nothing
// happens here that the test did not say. Every step fails the test by an exception where it takes longer
// than 20 s.
#pragma once

#include <gtest/gtest.h>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "client/shared/connection.h"
#include "protocol/mote.pb.h"
#include "tests/support/temp_dir.h"

namespace mote::test {

// Frames as a server sends them, made without the server's encoder: message and payload. Pure functions.

/// RGBA of a picture without two like rows; alpha is 1. SRGB8 or LINEAR_HALF.
std::vector<std::uint8_t> samplePixels(std::uint32_t width, std::uint32_t height, proto::PixelFormat format);

proto::Frame frameMessage(std::uint32_t width, std::uint32_t height, proto::PixelFormat format,
                          proto::Frame::Encoding encoding);

/// The row filter and zstd.
std::string zstdPayload(const std::vector<std::uint8_t>& rgba, std::uint32_t width,
                        proto::PixelFormat format);

/// Quality 100, 4:4:4.
std::string jpegPayload(const std::vector<std::uint8_t>& rgba, std::uint32_t width);

class FakeServer {
  public:
    static constexpr const char* token = "00112233445566778899aabbccddeeff";

    /// Listens and writes the connection file.
    FakeServer();
    ~FakeServer();
    FakeServer(const FakeServer&) = delete;
    FakeServer& operator=(const FakeServer&) = delete;

    std::filesystem::path connectionFile() const { return folder_ / "connection.json"; }

    /// Accepts a connection and exchanges greetings.
    void accept();
    /// The two halves of it: hears the client's greeting, and says ours.
    void acceptUngreeted();
    void greet();
    /// accept(), Hello and Welcome.
    /// `minor`: of the protocol that it speaks.
    void welcome(std::uint32_t minor = 0);
    /// The same with whatever else the welcome is to say. Returns the hello.
    proto::Hello welcome(proto::Welcome welcome);
    /// Accepts a connection, sends greeting and `reason` at once and closes, without having read a byte.
    void turnAway(const proto::ServerMessage& reason);
    proto::ClientMessage read();
    /// The next message with this body; others (pings, credits) are let pass.
    proto::ClientMessage read(proto::ClientMessage::BodyCase body);
    /// Whether nothing more is to be read right now.
    bool quiet() const;
    void send(const proto::ServerMessage& message, const std::string& payload = {});
    void sendRaw(const std::string& bytes);
    /// Closes the half of the connection that the client writes to.
    void stopReading();
    /// Closes the connection, goes on listening.
    void drop();
    /// Ends as a killed server does: the socket's file stays.
    void stop();

  private:
    void acceptSocket();
    std::string receive(std::size_t size);

    TempDir folder_;
    int listener_ = -1;
    int client_ = -1;
};

}  // namespace mote::test

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

/// A Connection and the FakeServer at its other end, and what their tests ask again and again.
/// One thread, the test's.
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
