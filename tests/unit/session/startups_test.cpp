// SPDX-License-Identifier: GPL-3.0-or-later
//
// Who has shown no token yet: how many there may be, who of them goes, and that whoever shows one gets in.
#include "server/session/startups.h"

#include <memory>
#include <random>

#include "tests/unit/session/session_fixture.h"
#include "tests/unit/storage/tiny_dataset.h"

namespace mote::test {
namespace {

using server::FailureDelay;
using server::StartupLimits;
using namespace std::chrono_literals;

TEST(StartupLimits, DropMoreTheMoreThereAre) {
    const StartupLimits limits{.start = 10, .full = 20, .rate = 0.3};
    EXPECT_EQ(limits.dropped(0), 0.0);
    EXPECT_EQ(limits.dropped(9), 0.0);
    EXPECT_DOUBLE_EQ(limits.dropped(10), 0.3);
    EXPECT_DOUBLE_EQ(limits.dropped(15), 0.65);
    EXPECT_EQ(limits.dropped(20), 1.0);
    EXPECT_EQ(limits.dropped(2000), 1.0);
}

TEST(FailureDelay, GrowsWithFailuresAndIsForgotten) {
    FailureDelay delay;
    const FailureDelay::Time start(std::chrono::hours(1));
    EXPECT_EQ(delay.next(start), FailureDelay::first);
    EXPECT_EQ(delay.next(start), 2 * FailureDelay::first);
    EXPECT_EQ(delay.next(start), 4 * FailureDelay::first);
    for (int i = 0; i < 1000; ++i) EXPECT_LE(delay.next(start), FailureDelay::longest);
    EXPECT_EQ(delay.next(start), FailureDelay::longest);
    EXPECT_EQ(delay.next(start + std::chrono::hours(1)), FailureDelay::first);
}

class Startups : public SessionFixture {
  protected:
    Startups() {
        settings_.random = [generator = std::mt19937_64(20261124)]() mutable {
            return std::uniform_real_distribution<double>(0.0, 1.0)(generator);
        };
    }
};

TEST_F(Startups, TakeNoPlacesOfSessions) {
    settings_.maxSessions = 2;
    start();
    std::vector<std::unique_ptr<TestClient>> silent;
    for (int i = 0; i < 20; ++i) silent.push_back(std::make_unique<TestClient>(socket()));
    const auto one = client();
    const auto two = client();
    one->barrier();
    two->barrier();
}

/// Strangers fill all places, and whenever one of theirs goes, another takes its place.
TEST_F(Startups, WhoeverShowsATokenGetsInAmongStrangersWithoutEnd) {
    settings_.startups = {.start = 20, .full = 60, .rate = 0.3};
    settings_.handshakeTimeout = 60s;  // no place is free again by waiting
    start();
    const auto known = client();
    std::vector<std::unique_ptr<TestClient>> strangers;
    for (int i = 0; i < 500; ++i) strangers.push_back(std::make_unique<TestClient>(socket()));
    int welcomed = 0;
    for (int i = 0; i < 20; ++i) {
        for (int k = 0; k < 5; ++k) strangers.push_back(std::make_unique<TestClient>(socket()));
        TestClient honest(socket());
        if (honest.connect(connection_.token()).message.has_welcome()) ++welcomed;
    }
    // Each of them is dropped with a chance of some 1/60 for each stranger that comes while it says hello.
    EXPECT_GE(welcomed, 15);
    known->barrier();
}

TEST_F(Startups, WhoIsDroppedHearsWhy) {
    settings_.startups = {.start = 1, .full = 1, .rate = 1.0};
    settings_.random = [] { return 0.0; };  // the first of those who are there
    start();
    TestClient first(socket());
    first.greet();
    TestClient second(socket());
    const auto reason = first.receive();
    ASSERT_TRUE(reason);
    EXPECT_EQ(reason->message.failure().code(), "resource_exhausted");
    EXPECT_EQ(reason->message.failure().where(), "server");
    EXPECT_TRUE(first.atEnd());
    EXPECT_TRUE(second.connect(connection_.token()).message.has_welcome());
}

TEST_F(Startups, TheNewestMayBeTheOneThatGoes) {
    settings_.startups = {.start = 1, .full = 1, .rate = 1.0};
    settings_.random = [] { return 0.999; };
    start();
    TestClient first(socket());
    first.greet();
    TestClient second(socket());
    second.greet();
    const auto reason = second.receive();
    ASSERT_TRUE(reason);
    EXPECT_EQ(reason->message.failure().code(), "resource_exhausted");
    EXPECT_TRUE(second.atEnd());
}

/// For an hour, here: the others are served meanwhile, and the end comes before the answer.
TEST_F(Startups, AWrongTokenWaitsForItsAnswer) {
    settings_.failureDelay = FailureDelay(1h, 1h);
    settings_.handshakeTimeout = 2h;
    start();
    TestClient stranger(socket());
    stranger.greet();
    proto::ClientMessage hello;
    hello.mutable_hello()->set_token("00");
    stranger.send(hello);
    client()->barrier();
    stop();
    const auto last = stranger.receive();
    ASSERT_TRUE(last);
    EXPECT_EQ(last->message.failure().code(), "cancelled") << "it was told that the token is wrong";
}

/// A look at the disk would find what was published meanwhile, and tell everybody.
TEST_F(Startups, StrangersCauseNoLookAtTheDisk) {
    settings_.rescanInterval = 1h;
    settings_.failureDelay = FailureDelay(0ms, 0ms);
    TinyDataset().write(folder_ / "data" / "old.mote");
    start();
    const auto known = client();
    proto::ClientMessage list, describe;
    list.mutable_list_datasets();
    describe.mutable_describe()->set_dataset("data/old");  // what is not known would be looked for
    known->ask(describe);                                  // what was to be looked for when it came has been
    EXPECT_EQ(known->ask(list).message.catalogue().datasets_size(), 1);
    TinyDataset().write(folder_ / "data" / "new.mote");
    for (int i = 0; i < 20; ++i) {
        TestClient silent(socket());
        silent.greet();
        TestClient wrong(socket());
        wrong.connect("00");
        EXPECT_TRUE(wrong.atEnd());
    }
    // It is answered by the thread that looks, after all that was to be looked for.
    describe.set_request(1000);
    known->send(describe);
    const auto next = known->receive();
    ASSERT_TRUE(next);
    EXPECT_EQ(next->message.reply_to(), 1000u) << next->message.ShortDebugString();
    describe.mutable_describe()->set_dataset("data/none");
    known->ask(describe);
    EXPECT_EQ(known->ask(list).message.catalogue().datasets_size(), 2) << "there was something to be found";
}

TEST_F(Startups, TheEndOfTheServerEndsThem) {
    start();
    TestClient stranger(socket());
    stranger.greet();
    stop();
    EXPECT_TRUE(stranger.atEnd());
}

}  // namespace
}  // namespace mote::test
