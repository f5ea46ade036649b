// SPDX-License-Identifier: GPL-3.0-or-later
//
// Connections that end, come back, or never were.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <algorithm>
#include <atomic>
#include <fstream>
#include <thread>

#include "tests/unit/client/fake_server.h"

namespace mote::client {
namespace {

using testing::HasSubstr;

using State = Connection::State;

TEST_F(ConnectionTest, ALostServerAnswersEveryQuestionWithTheReason) {
    connect();
    int answered = 0;
    const auto count = [&](const auto& reply) { answered += !reply.ok() && !reply.error().message.empty(); };
    connection_->listDatasets(count);
    connection_->watchJobs(count);
    server_.read();
    server_.read();
    server_.drop();
    ASSERT_TRUE(eventually(*connection_, [&] { return answered == 2; }));
    EXPECT_EQ(connection_->state(), State::lost);
    EXPECT_THAT(connection_->lostReason()->message, HasSubstr("closed the connection"));
    connection_->ping(count);  // asked of a lost connection: answered all the same
    ASSERT_TRUE(eventually(*connection_, [&] { return answered == 3; }));
}

TEST_F(ConnectionTest, ReconnectAsksForTheLatestViewAgain) {
    connect();
    connection_->setView(viewOfWidth(6), {});
    server_.read();
    server_.drop();
    ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::lost; }));
    connection_->reconnect();
    EXPECT_EQ(connection_->state(), State::connecting);
    EXPECT_FALSE(connection_->lostReason());
    server_.welcome();
    const auto message = server_.read();
    ASSERT_TRUE(message.has_set_view());
    EXPECT_EQ(message.set_view().view().width(), 6U);
    sendFrame(message.set_view().view_id(), 6);
    EXPECT_EQ(frameOf(*connection_).pixels.width, 6U);
}

TEST_F(ConnectionTest, ReconnectGivesUpWhatTheOldConnectionWasAsked) {
    connect();
    std::optional<Error> given;
    connection_->listDatasets([&](const Result<proto::Catalogue>& reply) { given = reply.error(); });
    server_.read();
    connection_->reconnect();
    server_.welcome();
    ASSERT_TRUE(eventually(*connection_, [&] { return given.has_value(); }));
    EXPECT_THAT(given->message, HasSubstr("given up"));
    std::string described;
    connection_->describe("data/a",
                          [&](const Result<proto::Description>& reply) { described = reply->dataset(); });
    proto::ServerMessage message;
    message.set_reply_to(server_.read().request());
    message.mutable_description()->set_dataset("data/a");
    server_.send(message);
    ASSERT_TRUE(eventually(*connection_, [&] { return described == "data/a"; }));
}

TEST_F(ConnectionTest, AFatalFailureIsTheReason) {
    connect();
    proto::ServerMessage failure;
    failure.mutable_failure()->set_code("resource_exhausted");
    failure.mutable_failure()->set_message("the message is too long");
    failure.mutable_failure()->set_fatal(true);
    server_.send(failure);
    server_.drop();
    ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::lost; }));
    EXPECT_EQ(connection_->lostReason()->code, ErrorCode::resourceExhausted);
}

proto::ServerMessage tooMany() {
    proto::ServerMessage failure;
    failure.mutable_failure()->set_code("resource_exhausted");
    failure.mutable_failure()->set_where("server");
    failure.mutable_failure()->set_message("it has as many clients as it takes");
    failure.mutable_failure()->set_fatal(true);
    return failure;
}

/// Whichever of the server's last words and our failing write comes first.
TEST_F(ConnectionTest, WhoIsTurnedAwayHearsWhy) {
    for (int turn = 0; turn < 100; ++turn) {
        connection_.emplace(server_.connectionFile(), quietSettings());
        server_.turnAway(tooMany());
        ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::lost; }));
        ASSERT_EQ(connection_->lostReason()->code, ErrorCode::resourceExhausted) << "turn " << turn;
        ASSERT_THAT(connection_->lostReason()->message, HasSubstr("as many clients"));
        connection_.reset();
    }
}

TEST_F(ConnectionTest, WhatTheServerSaidBeforeItClosedIsTheReasonThoughOurWritesFail) {
    for (int turn = 0; turn < 100; ++turn) {
        connect();
        server_.send(tooMany());
        server_.drop();
        connection_->setView(viewOfWidth(5), {});
        ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::lost; }));
        ASSERT_EQ(connection_->lostReason()->code, ErrorCode::resourceExhausted) << "turn " << turn;
        connection_.reset();
    }
}

/// It hears nobody any more and says nothing: its line is not waited for.
TEST_F(ConnectionTest, AServerThatReadsNoMoreIsLostInTheEnd) {
    connect();
    server_.stopReading();
    connection_->setView(viewOfWidth(5), {});
    ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::lost; }));
    EXPECT_THAT(connection_->lostReason()->message, HasSubstr("closed the connection"));
}

TEST_F(ConnectionTest, GarbageInsteadOfAFrameEndsTheConnection) {
    const std::string garbage[] = {
        std::string(64, '\xff'),                        // lengths beyond every limit
        std::string("\x02\0\0\0\0\0\0\0\xff\xff", 10),  // a message that is none
        std::string("\0\0\0\x02\0\0\0\0", 8),           // 32 MiB of message
    };
    for (const auto& bytes : garbage) {
        connect();
        server_.sendRaw(bytes);
        ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::lost; }));
        EXPECT_FALSE(connection_->lostReason()->message.empty());
        connection_.reset();
    }
}

TEST_F(ConnectionTest, PingsOnItsOwnAndKnowsTheRoundTrip) {
    auto settings = quietSettings();
    settings.pingInterval = std::chrono::milliseconds(1);
    connection_.emplace(server_.connectionFile(), settings);
    server_.welcome();
    const auto ping = server_.read();
    ASSERT_TRUE(ping.has_ping());
    // While it is unanswered the round trip grows, and no second one is sent.
    ASSERT_TRUE(eventually(*connection_, [&] { return connection_->statistics().roundTripMs > 5.0; }));
    EXPECT_TRUE(server_.quiet());
    proto::ServerMessage pong;
    pong.set_reply_to(ping.request());
    pong.mutable_pong()->set_sent_ns(ping.ping().sent_ns());
    server_.send(pong);
    EXPECT_TRUE(server_.read().has_ping());
    EXPECT_GT(connection_->statistics().roundTripMs, 0.0);
}

TEST_F(ConnectionTest, AServerThatSaysNothingIsGivenUp) {
    auto settings = quietSettings();
    settings.connectTimeout = std::chrono::milliseconds(1);
    connection_.emplace(server_.connectionFile(), settings);
    ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::lost; }));
    EXPECT_THAT(connection_->lostReason()->message, HasSubstr("in time"));
}

TEST_F(ConnectionTest, WakesItsOwner) {
    std::atomic<int> woken = 0;
    auto settings = quietSettings();
    settings.wake = [&] { ++woken; };
    connection_.emplace(server_.connectionFile(), settings);
    server_.welcome();
    ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::connected; }));
    EXPECT_TRUE(eventually(*connection_, [&] { return woken > 0; }));
    connection_.reset();  // nothing calls after this
}

TEST_F(ConnectionTest, AnOversizedRequestIsRefusedHere) {
    connect();
    proto::JobRequest job;
    job.set_title(std::string(2U << 20, 'x'));
    std::optional<ErrorCode> code;
    connection_->submitJob(job, [&](const Result<proto::JobStatus>& reply) { code = reply.error().code; });
    ASSERT_TRUE(eventually(*connection_, [&] { return code.has_value(); }));
    EXPECT_EQ(*code, ErrorCode::invalidArgument);
    std::uint64_t failed = 0;
    connection_->onViewFailed([&](std::uint64_t id, const Error&) { failed = id; });
    proto::View view;
    view.add_layers()->set_dataset(std::string(2U << 20, 'x'));
    const auto id = connection_->setView(view, {});
    settle();
    EXPECT_EQ(failed, id);
    EXPECT_EQ(connection_->state(), State::connected);
}

TEST_F(ConnectionTest, ManyThreadsMayAskAtOnce) {
    connect();
    std::vector<std::thread> threads;
    for (std::uint32_t i = 0; i < 4; ++i) {
        threads.emplace_back([&, i] {
            for (std::uint32_t j = 0; j < 50; ++j) {
                connection_->setView(viewOfWidth(100 * i + j + 1), {});
                connection_->statistics();
                connection_->describe("data/a", {});
            }
        });
    }
    std::uint64_t last = 0;
    int questions = 0;
    while (questions < 200 || last < 200) {
        const auto message = server_.read();
        questions += message.has_describe();
        if (message.has_set_view()) {
            EXPECT_GT(message.set_view().view_id(), last);
            last = message.set_view().view_id();
        }
    }
    for (auto& thread : threads) thread.join();
    EXPECT_EQ(last, 200U);  // whatever was left out, the last one was not
}

TEST(ConnectionFile, AMissingOrWrongFileIsALostConnection) {
    const test::TempDir folder;
    const auto reason = [&](const std::string& name) {
        Connection connection(folder / name, quietSettings());
        EXPECT_TRUE(eventually(connection, [&] { return connection.state() == State::lost; }));
        return connection.lostReason().value_or(Error{});
    };
    EXPECT_EQ(reason("missing.json").code, ErrorCode::notFound);
    std::ofstream(folder / "bad.json") << "{\"adress\": 1}";
    ::chmod((folder / "bad.json").c_str(), 0600);
    EXPECT_EQ(reason("bad.json").code, ErrorCode::invalidArgument);
    EXPECT_THAT(reason("bad.json").toString(), HasSubstr("bad.json"));
}

TEST(ConnectionFile, AServerThatHasEndedIsSaidSo) {
    FakeServer server;
    server.stop();
    Connection connection(server.connectionFile(), quietSettings());
    ASSERT_TRUE(eventually(connection, [&] { return connection.state() == State::lost; }));
    EXPECT_THAT(connection.lostReason()->message, HasSubstr("no server listens"));
}

// Lines that break and are opened again, as those to a server that died and was started again.

using testing::ElementsAre;

class ConnectionReturnTest : public ConnectionTest {
  protected:
    static ConnectionSettings patient(std::chrono::milliseconds patience = std::chrono::seconds(20)) {
        auto settings = quietSettings();
        settings.returnPatience = patience;
        return settings;
    }
};

TEST_F(ConnectionReturnTest, TheLatestViewIsAskedForAgain) {
    connect(patient());
    std::vector<State> states;
    connection_->onState([&](State state) { states.push_back(state); });
    connection_->setView(viewOfWidth(6), {});
    server_.read();
    server_.drop();
    server_.welcome();
    const auto message = server_.read();
    ASSERT_TRUE(message.has_set_view());
    EXPECT_EQ(message.set_view().view().width(), 6U);
    sendFrame(message.set_view().view_id(), 6);
    EXPECT_EQ(frameOf(*connection_).pixels.width, 6U);
    EXPECT_EQ(states.back(), State::connected);
    EXPECT_EQ(std::count(states.begin(), states.end(), State::lost), 0);
    EXPECT_FALSE(connection_->lostReason());
}

TEST_F(ConnectionReturnTest, QuestionsAreAskedAgainInOrderAndAnsweredOnce) {
    connect(patient());
    std::vector<std::string> answers;
    connection_->describe("data/a", [&](const auto& reply) { answers.push_back(reply->dataset()); });
    server_.read();
    connection_->listDatasets([&](const auto& reply) { answers.push_back(reply.ok() ? "list" : "none"); });
    server_.drop();
    server_.welcome();
    const auto describe = server_.read();
    ASSERT_TRUE(describe.has_describe());
    EXPECT_EQ(describe.describe().dataset(), "data/a");
    const auto list = server_.read();
    ASSERT_TRUE(list.has_list_datasets());
    proto::ServerMessage description, catalogue;
    description.set_reply_to(describe.request());
    description.mutable_description()->set_dataset("data/a");
    catalogue.set_reply_to(list.request());
    catalogue.mutable_catalogue();
    server_.send(description);
    server_.send(catalogue);
    ASSERT_TRUE(eventually(*connection_, [&] { return answers.size() == 2; }));
    EXPECT_THAT(answers, ElementsAre("data/a", "list"));
}

/// The socket of a server that is started anew is there a moment before its connection file.
TEST_F(ConnectionReturnTest, ATokenOfTheServerBeforeIsNotTheEnd) {
    connect(patient());
    connection_->setView(viewOfWidth(6), {});
    server_.read();
    server_.drop();
    for (int i = 0; i < 3; ++i) {
        server_.accept();
        proto::ServerMessage failure;
        failure.set_reply_to(server_.read(proto::ClientMessage::kHello).request());
        failure.mutable_failure()->set_code("permission_denied");
        failure.mutable_failure()->set_message("the token is not this server's");
        failure.mutable_failure()->set_fatal(true);
        server_.send(failure);
        server_.drop();
    }
    server_.welcome();
    EXPECT_EQ(server_.read(proto::ClientMessage::kSetView).set_view().view().width(), 6U);
    EXPECT_EQ(connection_->state(), State::connected);
}

TEST_F(ConnectionReturnTest, AJobIsNotSubmittedTwice) {
    connect(patient());
    std::optional<Error> failure;
    connection_->submitJob({}, [&](const Result<proto::JobStatus>& reply) { failure = reply.error(); });
    ASSERT_TRUE(server_.read().has_submit_job());
    server_.drop();
    server_.welcome();
    ASSERT_TRUE(eventually(*connection_, [&] { return failure.has_value(); }));
    EXPECT_THAT(failure->message, HasSubstr("closed the connection"));
    settle();
    EXPECT_TRUE(server_.quiet());
}

TEST_F(ConnectionReturnTest, WhatTheServerSaidFarewellToIsLostAtOnce) {
    connect(patient());
    proto::ServerMessage farewell;
    farewell.mutable_failure()->set_code("cancelled");
    farewell.mutable_failure()->set_message("the server ends");
    farewell.mutable_failure()->set_fatal(true);
    server_.send(farewell);
    server_.drop();
    ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::lost; }));
    EXPECT_EQ(connection_->lostReason()->message, "the server ends");
}

TEST_F(ConnectionReturnTest, PatienceEndsAndTheFirstReasonStands) {
    connect(patient(std::chrono::milliseconds(100)));
    server_.drop();
    server_.stop();
    ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::lost; }));
    EXPECT_THAT(connection_->lostReason()->message, HasSubstr("closed the connection"));
}

TEST_F(ConnectionReturnTest, AServerThatDropsUsAgainAndAgainIsGivenUp) {
    const std::chrono::milliseconds patience(500);
    connect(patient(patience));
    server_.drop();
    server_.welcome();
    settle();
    std::this_thread::sleep_for(patience);
    server_.drop();  // less than a second after it took us on again
    ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::lost; }));
}

// A connection whose session goes on: by its secret, through servers that have no place, through silence.

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
