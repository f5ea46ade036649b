// SPDX-License-Identifier: GPL-3.0-or-later
//
// Connections that end, come back, or never were.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <atomic>
#include <fstream>
#include <thread>

#include "tests/unit/client/connection_fixture.h"

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

}  // namespace
}  // namespace mote::client
