// SPDX-License-Identifier: GPL-3.0-or-later
//
// Followers: they see what others see, by a token of their own, and change nothing.
#include <sys/stat.h>

#include "tests/unit/session/session_fixture.h"

namespace mote::test {
namespace {

class SessionFollow : public SessionFixture {
  protected:
    SessionFollow() { settings_.followerFile = folder_ / "follow.json"; }

    std::unique_ptr<TestClient> follower() {
        const auto file = wire::readConnectionFile(settings_.followerFile);
        EXPECT_TRUE(file.ok());
        EXPECT_NE(file->token(), connection_.token());
        auto made = std::make_unique<TestClient>(socket());
        const auto welcome = made->connect(file->token()).message.welcome();
        EXPECT_TRUE(welcome.follower());
        EXPECT_EQ(welcome.resume(), "");
        return made;
    }

    static Received follow(TestClient& client, std::uint64_t session) {
        proto::ClientMessage message;
        message.mutable_follow()->set_session(session);
        return client.ask(message);
    }
};

TEST_F(SessionFollow, PicturesOfAnothersViewComeAsItChanges) {
    start();
    TestClient leader(socket());
    const auto session = leader.connect(connection_.token()).message.welcome().session();
    leader.setView(5, 16);
    leader.barrier();
    const auto watching = follower();
    const auto followed = follow(*watching, session).message.followed();
    EXPECT_EQ(followed.session(), session);
    EXPECT_EQ(followed.client(), "test");
    EXPECT_EQ(followed.view().view_id(), 5u);
    EXPECT_EQ(watching->receiveFrame().message.frame().view_id(), 5u);
    watching->credit(1);
    leader.setView(6, 24);
    const auto told =
        watching->receive([](const proto::ServerMessage& message) { return message.has_followed(); });
    EXPECT_EQ(told.message.followed().view().view().width(), 24u);
    const auto frame = watching->receive([](const proto::ServerMessage& message) {
        return message.has_frame() && message.frame().view_id() == 6;
    });
    EXPECT_EQ(frame.message.frame().width(), 24u);
}

TEST_F(SessionFollow, WhoDropsAndComesBackIsFollowedOn) {
    start();
    auto leader = std::make_unique<TestClient>(socket());
    const auto welcome = leader->connect(connection_.token()).message.welcome();
    leader->setView(5, 16);
    leader->barrier();
    const auto watching = follower();
    follow(*watching, welcome.session());
    leader = std::make_unique<TestClient>(socket());
    proto::Hello hello;
    hello.set_token(connection_.token());
    hello.set_resume(welcome.resume());
    const auto now = leader->connect(hello).message.welcome().session();
    const auto told = watching->receive([&](const proto::ServerMessage& message) {
        return message.has_followed() && message.followed().session() == now;
    });
    EXPECT_EQ(told.message.followed().view().view_id(), 5u);
}

TEST_F(SessionFollow, WhatWouldChangeSomethingIsRefused) {
    start();
    const auto watching = follower();
    for (const int command : {0, 1, 2, 3, 4, 5, 6, 7, 8}) {
        proto::ClientMessage message;
        if (command == 0) message.mutable_submit_job();
        if (command == 1) message.mutable_cancel_job();
        if (command == 2) message.mutable_retry_job();
        if (command == 3) message.mutable_upload();
        if (command == 4) message.mutable_watch_jobs();
        if (command == 5) message.mutable_list_jobs();
        if (command == 6) message.mutable_fetch_film();
        if (command == 7) message.mutable_list_folder();
        if (command == 8) message.mutable_look_at_file()->set_input("data/run.h5");
        const auto answer = watching->ask(message).message;
        EXPECT_EQ(answer.failure().code(), "permission_denied") << message.ShortDebugString();
        EXPECT_FALSE(answer.failure().fatal());
    }
    proto::ClientMessage list;
    list.mutable_list_datasets();
    EXPECT_TRUE(watching->ask(list).message.has_catalogue());
}

TEST_F(SessionFollow, TheListTellsWhomOneCanFollow) {
    start();
    TestClient leader(socket());
    const auto session = leader.connect(connection_.token()).message.welcome().session();
    const auto film = client(true);
    const auto watching = follower(), other = follower();
    proto::ClientMessage list;
    list.mutable_list_sessions();
    const auto sessions = watching->ask(list).message.sessions();
    ASSERT_EQ(sessions.sessions_size(), 1) << "films and followers show nothing";
    EXPECT_EQ(sessions.sessions(0).session(), session);
    EXPECT_EQ(follow(*watching, session + 100).message.failure().code(), "not_found");
}

TEST_F(SessionFollow, TheirFileIsPrivateAndGoesWithTheServer) {
    start();
    struct stat status {};
    ASSERT_EQ(::stat(settings_.followerFile.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600u);
    stop();
    EXPECT_FALSE(std::filesystem::exists(settings_.followerFile));
}

}  // namespace
}  // namespace mote::test
