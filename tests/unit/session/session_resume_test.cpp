// SPDX-License-Identifier: GPL-3.0-or-later
//
// Clients that come back: with what, in whose place, and by which secret.
#include "protocol/wire/private_file.h"
#include "server/session/parked_sessions.h"
#include "tests/unit/session/session_fixture.h"

namespace mote::test {
namespace {

class SessionResume : public SessionFixture {
  protected:
    /// Says hello to take a session up; its welcome.
    proto::Welcome resume(TestClient& client, const std::string& secret) const {
        proto::Hello hello;
        hello.set_token(connection_.token());
        hello.set_resume(secret);
        const auto answer = client.connect(hello);
        EXPECT_TRUE(answer.message.has_welcome()) << answer.message.ShortDebugString();
        return answer.message.welcome();
    }
};

TEST_F(SessionResume, TheViewComesBackWithoutBeingAskedFor) {
    start();
    std::string secret;
    {
        TestClient first(socket());
        const auto welcome = resume(first, "");
        EXPECT_FALSE(welcome.resumed());
        EXPECT_FALSE(welcome.has_view());
        EXPECT_NE(welcome.session(), 0u);
        secret = welcome.resume();
        first.setView(7, 24, false);
        EXPECT_EQ(first.receiveFrame().message.frame().view_id(), 7u);
    }
    TestClient second(socket());
    const auto welcome = resume(second, secret);
    EXPECT_TRUE(welcome.resumed());
    EXPECT_EQ(welcome.view().view_id(), 7u);
    EXPECT_EQ(welcome.view().view().width(), 24u);
    EXPECT_NE(welcome.resume(), secret);
    EXPECT_EQ(second.receiveFrame().message.frame().view_id(), 7u);
}

TEST_F(SessionResume, OfQueuedViewsNothingStays) {
    start();
    TestClient first(socket());
    const auto secret = resume(first, "").resume();
    first.setView(1, 16);
    first.queueView(2, 16);
    first.barrier();
    TestClient second(socket());
    EXPECT_EQ(resume(second, secret).view().view_id(), 1u);
}

TEST_F(SessionResume, JobsAreToldAtOnce) {
    start();
    TestClient first(socket());
    const auto secret = resume(first, "").resume();
    proto::ClientMessage watch;
    watch.mutable_watch_jobs();
    first.ask(watch);
    TestClient second(socket());
    resume(second, secret);
    const auto jobs = second.receive([](const proto::ServerMessage& message) { return message.has_jobs(); });
    EXPECT_EQ(jobs.message.reply_to(), 0u);
}

/// A connection that died without a farewell holds no place against its own client.
TEST_F(SessionResume, WhoComesBackTakesTheirOwnPlace) {
    settings_.maxSessions = 1;
    start();
    TestClient first(socket());
    const auto secret = resume(first, "").resume();
    first.barrier();
    TestClient stranger(socket());
    EXPECT_EQ(stranger.connect(connection_.token()).message.failure().code(), "resource_exhausted");
    TestClient second(socket());
    EXPECT_TRUE(resume(second, secret).resumed());
    const auto farewell =
        first.receive([](const proto::ServerMessage& message) { return message.has_failure(); });
    EXPECT_EQ(farewell.message.failure().where(), "session");
    EXPECT_TRUE(farewell.message.failure().fatal());
    EXPECT_TRUE(first.atEnd());
    second.barrier();
}

TEST_F(SessionResume, ASecretIsGoodOnceAndOnlyWithTheToken) {
    start();
    TestClient first(socket());
    const auto secret = resume(first, "").resume();
    TestClient stranger(socket());
    proto::Hello hello;
    hello.set_resume(secret);
    EXPECT_EQ(stranger.connect(hello).message.failure().where(), "hello.token");
    TestClient second(socket());
    EXPECT_TRUE(resume(second, secret).resumed());
    second.barrier();
    TestClient third(socket());
    EXPECT_FALSE(resume(third, secret).resumed());
    second.barrier();
}

TEST_F(SessionResume, TheViewOutlivesTheServer) {
    start();
    std::string secret;
    {
        TestClient first(socket());
        secret = resume(first, "").resume();
        first.setView(7, 24);
        first.barrier();
    }
    stop();
    start();
    TestClient second(socket());
    const auto welcome = resume(second, secret);
    EXPECT_TRUE(welcome.resumed());
    EXPECT_EQ(welcome.view().view_id(), 7u);
    EXPECT_EQ(second.receiveFrame().message.frame().view_id(), 7u);
}

/// A server that is killed has written it before.
TEST_F(SessionResume, TheViewIsWrittenWhileTheServerRuns) {
    settings_.parkingPause = std::chrono::milliseconds(1);
    start();
    TestClient first(socket());
    const auto secret = resume(first, "").resume();
    first.setView(7, 24);
    const auto written = [&] {
        const auto text = wire::readPrivateFile(settings_.stateDirectory / "sessions");
        if (!text.ok()) return false;
        server::ParkedSessions parked;
        const auto* const bytes = reinterpret_cast<const std::uint8_t*>(text->data());
        EXPECT_TRUE(parked.add({bytes, text->size()}, {}).ok());
        const auto admission = parked.admit(secret, 1, {});
        return admission.state.view && admission.state.view->view_id() == 7;
    };
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!written() && std::chrono::steady_clock::now() < end) first.barrier();
    EXPECT_TRUE(written());
}

TEST_F(SessionResume, ADamagedFileIsNoReasonNotToServe) {
    std::filesystem::create_directory(settings_.stateDirectory);
    std::filesystem::permissions(settings_.stateDirectory, std::filesystem::perms::owner_all);
    ASSERT_TRUE(wire::writePrivateFile(settings_.stateDirectory / "sessions", "no sessions").ok());
    start();
    client()->barrier();
}

TEST_F(SessionResume, ALostWelcomeLosesNothing) {
    start();
    TestClient first(socket());
    const auto secret = resume(first, "").resume();
    first.setView(3, 16);
    first.barrier();
    for (int i = 0; i < 5; ++i) {
        TestClient lost(socket());
        EXPECT_EQ(resume(lost, secret).view().view_id(), 3u) << i;
    }
}

}  // namespace
}  // namespace mote::test
