// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lines that break and are opened again, as those to a server that died and was started again.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "tests/unit/client/connection_fixture.h"

namespace mote::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

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

}  // namespace
}  // namespace mote::client
