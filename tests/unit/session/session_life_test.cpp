// SPDX-License-Identifier: GPL-3.0-or-later
//
// Sessions whose client is silent, or wants nothing.
#include "server/session/client_life.h"
#include "tests/unit/session/session_fixture.h"

namespace mote::test {
namespace {

using namespace std::chrono_literals;

TEST(ClientLife, LooksOftenEnoughForBoth) {
    proto::Hello hello;
    hello.set_minor(wire::ownVersion.minor);
    const auto interval = [&](auto silence, auto idle) {
        return server::ClientLife(hello, silence, idle, {}).interval();
    };
    EXPECT_EQ(server::ClientLife().interval(), 0ms);
    EXPECT_EQ(interval(0ms, 0ms), 0ms);
    EXPECT_EQ(interval(800ms, 0ms), 100ms);
    EXPECT_EQ(interval(0ms, 80ms), 10ms);
    EXPECT_EQ(interval(800ms, 80ms), 10ms);
    hello.set_background(true);
    EXPECT_EQ(interval(0ms, 80ms), 0ms) << "it waits as long as others work";
    hello.set_minor(0);
    EXPECT_EQ(interval(800ms, 0ms), 0ms) << "it knows no pings";
}

TEST(ClientLife, WishesAndWhatIsWaitedForKeepItFromBeingIdle) {
    server::Clock::time_point now;
    server::ClientLife life({}, 0ms, 100ms, now);
    proto::ClientMessage list, pong;
    list.mutable_list_datasets();
    pong.mutable_pong();
    proto::ServerMessage frame;
    frame.mutable_frame();
    now += 90ms;
    life.heard(list, now);
    now += 90ms;
    EXPECT_FALSE(life.at(now, 0).end);
    life.told(frame, now);
    now += 90ms;
    life.heard(pong, now);
    EXPECT_FALSE(life.at(now, 0).end);
    now += 10ms;
    EXPECT_EQ(life.at(now, 0).end->message, "it was idle for 100 ms; connect again to go on");
}

class SessionLife : public SessionFixture {
  protected:
    /// A client that knows pings.
    std::unique_ptr<TestClient> newClient(bool background = false) {
        auto made = std::make_unique<TestClient>(socket());
        proto::Hello hello;
        hello.set_token(connection_.token());
        hello.set_minor(wire::ownVersion.minor);
        hello.set_background(background);
        welcome_ = made->connect(hello).message.welcome();
        return made;
    }

    static bool isFailure(const proto::ServerMessage& message) { return message.has_failure(); }
    static bool isPing(const proto::ServerMessage& message) { return message.has_ping(); }

    proto::Welcome welcome_;
};

TEST_F(SessionLife, ASilentClientIsAskedAndThenToldThatItIsOver) {
    settings_.silence = 20ms;
    start();
    const auto silent = newClient();
    EXPECT_EQ(welcome_.silence_ms(), 20u);
    silent->receive(isPing);
    const auto farewell = silent->receive(isFailure).message.failure();
    EXPECT_EQ(farewell.where(), "silence");
    EXPECT_TRUE(farewell.fatal());
    EXPECT_NE(farewell.message().find("20 ms"), std::string::npos) << farewell.message();
    EXPECT_TRUE(silent->atEnd());
}

/// Each ping comes only where the answer to the one before it has kept the session alive.
TEST_F(SessionLife, WhoAnswersStays) {
    settings_.silence = 1s;
    start();
    const auto known = newClient();
    for (int i = 0; i < 3; ++i) {
        known->receive(isPing);
        proto::ClientMessage pong;
        pong.mutable_pong();
        ASSERT_TRUE(known->send(pong));
    }
    known->barrier();
}

TEST_F(SessionLife, AnOlderClientIsNotAsked) {
    settings_.silence = 20ms;
    start();
    const auto old = client();
    const auto silent = newClient();
    EXPECT_TRUE(silent->atEnd());  // many times the time has passed
    old->barrier();
}

TEST_F(SessionLife, AnIdleSessionEndsAndSaysSo) {
    settings_.idle = 20ms;
    start();
    const auto idle = client();
    const auto farewell = idle->receive(isFailure).message.failure();
    EXPECT_EQ(farewell.code(), "cancelled");
    EXPECT_EQ(farewell.where(), "session");
    EXPECT_NE(farewell.message().find("idle for 20 ms"), std::string::npos) << farewell.message();
    EXPECT_TRUE(idle->atEnd());
}

TEST_F(SessionLife, PingsAreNoWishes) {
    settings_.idle = 20ms;
    start();
    const auto idle = client();
    proto::ClientMessage ping;
    ping.mutable_ping();
    // It ends although pings never do.
    bool ended = false;
    while (!ended && idle->send(ping)) ended = idle->receive()->message.has_failure();
    EXPECT_TRUE(ended);
}

TEST_F(SessionLife, WhoWaitsBehindOthersIsNotIdle) {
    settings_.idle = 1ms;
    start();
    const auto background = newClient(true);
    const auto idle = client();
    EXPECT_TRUE(idle->atEnd());  // many times the time has passed
    background->barrier();
}

}  // namespace
}  // namespace mote::test
