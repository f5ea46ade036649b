// SPDX-License-Identifier: GPL-3.0-or-later
//
// A connection whose session goes on: by its secret, through servers that have no place, through silence.
#include <gmock/gmock.h>

#include "tests/unit/client/connection_fixture.h"

namespace mote::client {
namespace {

using testing::HasSubstr;

class ConnectionResumeTest : public ConnectionTest {
  protected:
    static ConnectionSettings patient() {
        auto settings = quietSettings();
        settings.returnPatience = std::chrono::seconds(20);
        return settings;
    }

    /// A welcome with this secret; of a session that goes on with a view, where one is given.
    static proto::Welcome welcomeWith(const std::string& secret, std::optional<proto::SetView> view = {}) {
        proto::Welcome welcome;
        welcome.set_minor(3);
        welcome.set_resume(secret);
        welcome.set_resumed(view.has_value());
        if (view) *welcome.mutable_view() = *view;
        return welcome;
    }

    void connectWith(const proto::Welcome& welcome, const ConnectionSettings& settings) {
        connection_.emplace(server_.connectionFile(), settings);
        EXPECT_EQ(server_.welcome(welcome).resume(), "");
        ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::connected; }));
    }

    static proto::ServerMessage farewell(const std::string& code, const std::string& where) {
        proto::ServerMessage message;
        message.mutable_failure()->set_code(code);
        message.mutable_failure()->set_where(where);
        message.mutable_failure()->set_message("a last word");
        message.mutable_failure()->set_fatal(true);
        return message;
    }

    /// The client comes back and is welcome; its hello.
    proto::Hello comeBack(const proto::Welcome& welcome) {
        const auto hello = server_.welcome(welcome);
        EXPECT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::connected; }));
        return hello;
    }
};

TEST_F(ConnectionResumeTest, EachLineIsOpenedWithTheLatestSecret) {
    connectWith(welcomeWith("one"), patient());
    server_.drop();
    EXPECT_EQ(comeBack(welcomeWith("two")).resume(), "one");
    settle();
    connection_->reconnect();
    EXPECT_EQ(comeBack(welcomeWith("three")).resume(), "two");
}

TEST_F(ConnectionResumeTest, AViewThatTheServerHasIsNotAskedForAgain) {
    connectWith(welcomeWith("one"), patient());
    connection_->setView(viewOfWidth(6), {});
    const auto asked = server_.read(proto::ClientMessage::kSetView).set_view();
    server_.drop();
    comeBack(welcomeWith("two", asked));
    bool answered = false;
    connection_->ping([&](const Result<double>&) { answered = true; });
    const auto ping = server_.read();
    EXPECT_TRUE(ping.has_ping()) << ping.ShortDebugString();
    proto::ServerMessage pong;
    pong.set_reply_to(ping.request());
    pong.mutable_pong();
    server_.send(pong);
    ASSERT_TRUE(eventually(*connection_, [&] { return answered; }));
    EXPECT_TRUE(server_.quiet());
    sendFrame(asked.view_id(), 6);
    EXPECT_EQ(frameOf(*connection_).pixels.width, 6U);
}

TEST_F(ConnectionResumeTest, AViewThatNeverArrivedIsAskedFor) {
    connectWith(welcomeWith("one"), patient());
    connection_->setView(viewOfWidth(6), {});
    const auto before = server_.read(proto::ClientMessage::kSetView).set_view();
    connection_->setView(viewOfWidth(7), {});
    server_.read(proto::ClientMessage::kSetView);
    server_.drop();
    comeBack(welcomeWith("two", before));
    EXPECT_EQ(server_.read(proto::ClientMessage::kSetView).set_view().view().width(), 7U);
}

/// The server draws it as if the hello had asked for it.
TEST_F(ConnectionResumeTest, AFailureOfTheViewThatGoesOnIsTold) {
    connectWith(welcomeWith("one"), patient());
    std::uint64_t failed = 0;
    connection_->onViewFailed([&](std::uint64_t id, const Error&) { failed = id; });
    const auto id = connection_->setView(viewOfWidth(6), {});
    const auto asked = server_.read(proto::ClientMessage::kSetView).set_view();
    server_.drop();
    server_.accept();
    const auto hello = server_.read(proto::ClientMessage::kHello);
    proto::ServerMessage welcome, failure;
    welcome.set_reply_to(hello.request());
    *welcome.mutable_welcome() = welcomeWith("two", asked);
    failure.set_reply_to(hello.request());
    failure.mutable_failure()->set_code("internal");
    server_.send(welcome);
    server_.send(failure);
    ASSERT_TRUE(eventually(*connection_, [&] { return failed != 0; }));
    EXPECT_EQ(failed, id);
}

TEST_F(ConnectionResumeTest, AServerWithoutAPlaceIsAskedAgainByWhoReturns) {
    connectWith(welcomeWith("one"), patient());
    server_.drop();
    for (int i = 0; i < 3; ++i) server_.turnAway(farewell("resource_exhausted", "server"));
    EXPECT_EQ(comeBack(welcomeWith("two")).resume(), "one");
    EXPECT_FALSE(connection_->brokenBy());
}

TEST_F(ConnectionResumeTest, AServerWithoutAPlaceIsAskedAgainByWhoComes) {
    connection_.emplace(server_.connectionFile(), patient());
    server_.turnAway(farewell("resource_exhausted", "server"));
    ASSERT_TRUE(eventually(*connection_, [&] { return connection_->brokenBy().has_value(); }));
    EXPECT_EQ(connection_->state(), State::connecting);
    comeBack(welcomeWith("one"));
}

/// This machine slept; nobody is to blame.
TEST_F(ConnectionResumeTest, WhoWasTooSilentComesBack) {
    connectWith(welcomeWith("one"), patient());
    server_.send(farewell("cancelled", "silence"));
    EXPECT_EQ(comeBack(welcomeWith("two")).resume(), "one");
}

TEST_F(ConnectionResumeTest, WhoIsTooLongIdleDoesNot) {
    auto settings = patient();
    settings.outlastsFarewells = true;
    connectWith(welcomeWith("one"), settings);
    server_.send(farewell("cancelled", "session"));
    ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::lost; }));
}

TEST_F(ConnectionResumeTest, AServerThatEndedIsWaitedForOnRequest) {
    auto settings = patient();
    settings.outlastsFarewells = true;
    connectWith(welcomeWith("one"), settings);
    server_.send(farewell("cancelled", "server"));
    EXPECT_EQ(comeBack(welcomeWith("two")).resume(), "one");
}

TEST_F(ConnectionResumeTest, PingsOfTheServerAreAnswered) {
    connectWith(welcomeWith("one"), quietSettings());
    proto::ServerMessage ping;
    ping.mutable_ping()->set_sent_ns(42);
    server_.send(ping);
    EXPECT_EQ(server_.read(proto::ClientMessage::kPong).pong().sent_ns(), 42);
}

TEST_F(ConnectionResumeTest, ASilentServerIsAskedAndThenLost) {
    auto welcome = welcomeWith("one");
    welcome.set_silence_ms(40);
    connectWith(welcome, quietSettings());
    server_.read(proto::ClientMessage::kPing);
    ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::lost; }));
    EXPECT_THAT(connection_->lostReason()->message, HasSubstr("nothing was heard of the server for 0.04 s"));
}

/// A long frame on a slow line is no message for a while, but no silence either.
TEST_F(ConnectionResumeTest, BytesOfAnUnfinishedMessageAreNoSilence) {
    auto welcome = welcomeWith("one");
    welcome.set_silence_ms(1000);
    connectWith(welcome, quietSettings());
    server_.sendRaw(std::string("\x40\0\0\0\0\0\0\0", 8));
    server_.read(proto::ClientMessage::kPing);  // after half of it
    // The ping that is not answered tells the time.
    for (double ms = 250.0; ms <= 1500.0; ms += 250.0) {
        server_.sendRaw("\x0a");
        const auto passed = [&] { return connection_->statistics().roundTripMs > ms; };
        ASSERT_TRUE(eventually(*connection_, passed));
        EXPECT_EQ(connection_->state(), State::connected);
    }
}

}  // namespace
}  // namespace mote::client
