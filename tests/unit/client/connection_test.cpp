// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/client/connection_fixture.h"

namespace mote::client {
namespace {

TEST_F(ConnectionTest, GreetsAuthenticatesAndSaysSo) {
    connection_.emplace(server_.connectionFile(), quietSettings());
    std::vector<State> states;
    connection_->onState([&](State state) { states.push_back(state); });
    EXPECT_EQ(connection_->state(), State::connecting);
    server_.accept();
    const auto hello = server_.read();
    ASSERT_TRUE(hello.has_hello());
    EXPECT_EQ(hello.hello().token(), FakeServer::token);
    EXPECT_EQ(hello.hello().client(), "connection test");
    EXPECT_EQ(connection_->state(), State::connecting);
    proto::ServerMessage welcome;
    welcome.mutable_welcome()->set_device("paper");
    server_.send(welcome);
    ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::connected; }));
    connection_->poll();
    EXPECT_EQ(states.back(), State::connected);
    EXPECT_EQ(connection_->welcome().device(), "paper");
    EXPECT_FALSE(connection_->lostReason());
}

TEST_F(ConnectionTest, TheHelloDoesNotWaitForTheServersGreeting) {
    connection_.emplace(server_.connectionFile(), quietSettings());
    server_.acceptUngreeted();
    EXPECT_TRUE(server_.read().has_hello());
    server_.greet();
    proto::ServerMessage welcome;
    welcome.mutable_welcome();
    server_.send(welcome);
    EXPECT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::connected; }));
}

TEST_F(ConnectionTest, ARefusedTokenIsTheReason) {
    connection_.emplace(server_.connectionFile(), quietSettings());
    server_.accept();
    proto::ServerMessage refusal;
    refusal.set_reply_to(server_.read().request());
    refusal.mutable_failure()->set_code("permission_denied");
    refusal.mutable_failure()->set_message("the token is wrong");
    refusal.mutable_failure()->set_fatal(true);
    server_.send(refusal);
    ASSERT_TRUE(eventually(*connection_, [&] { return connection_->state() == State::lost; }));
    EXPECT_EQ(connection_->lostReason()->code, ErrorCode::permissionDenied);
    EXPECT_EQ(connection_->lostReason()->message, "the token is wrong");
}

TEST_F(ConnectionTest, AnUnsentViewIsReplacedByTheLatest) {
    connection_.emplace(server_.connectionFile(), quietSettings());
    // Not connected yet: nothing can be sent, so only the last of these may ever be.
    for (std::uint32_t width = 1; width <= 5; ++width) connection_->setView(viewOfWidth(width), {});
    server_.welcome();
    const auto message = server_.read();
    ASSERT_TRUE(message.has_set_view());
    EXPECT_EQ(message.set_view().view().width(), 5U);
    EXPECT_EQ(message.set_view().view_id(), 5U);
    settle();
    EXPECT_TRUE(server_.quiet());
}

TEST_F(ConnectionTest, AViewCarriesItsRequest) {
    connect();
    ViewRequest request;
    request.finalOnly = true;
    request.format = proto::LINEAR_HALF;
    const auto first = connection_->setView(viewOfWidth(3), request);
    const auto message = server_.read().set_view();
    EXPECT_EQ(message.view_id(), first);
    EXPECT_TRUE(message.final_only());
    EXPECT_FALSE(message.moving());
    EXPECT_EQ(message.format(), proto::LINEAR_HALF);
    EXPECT_GT(message.asked_ns(), 0);
    EXPECT_GT(connection_->setView(viewOfWidth(4), {}), first);
}

TEST_F(ConnectionTest, AFrameArrivesDecodedAndItsCreditGoesBack) {
    connect();
    const auto id = connection_->setView(viewOfWidth(8), {});
    server_.read();
    sendFrame(id, 8);
    const auto frame = frameOf(*connection_);
    EXPECT_EQ(frame.message.view_id(), id);
    EXPECT_EQ(frame.pixels.bytes, test::samplePixels(8, 4, proto::SRGB8));
    EXPECT_FALSE(connection_->takeFrame());
    const auto credit = server_.read();
    ASSERT_TRUE(credit.has_credit());
    EXPECT_EQ(credit.credit().frames(), 1U);
    EXPECT_EQ(connection_->statistics().frames, 1U);
    EXPECT_GT(connection_->statistics().bytesPerSecond, 0.0);
}

TEST_F(ConnectionTest, TheNewestFrameIsTakenAndNoCreditIsLost) {
    connect();
    sendFrame(1, 8);
    sendFrame(2, 9);
    const auto unseen = server_.read();  // nobody took the first: its credit is back at once
    ASSERT_TRUE(unseen.has_credit());
    EXPECT_EQ(unseen.credit().frames(), 1U);
    const auto frame = frameOf(*connection_);
    EXPECT_EQ(frame.message.view_id(), 2U);
    EXPECT_EQ(frame.pixels.width, 9U);
    EXPECT_EQ(server_.read(proto::ClientMessage::kCredit).credit().frames(), 1U);
    EXPECT_EQ(connection_->statistics().frames, 2U);
}

TEST_F(ConnectionTest, ADamagedFrameIsAnErrorOfItsViewAndNotTheEnd) {
    connect();
    std::vector<std::pair<std::uint64_t, ErrorCode>> failures;
    connection_->onViewFailed(
        [&](std::uint64_t id, const Error& error) { failures.emplace_back(id, error.code); });
    proto::ServerMessage message;
    *message.mutable_frame() = test::frameMessage(8, 4, proto::SRGB8, proto::Frame::ZSTD);
    message.mutable_frame()->set_view_id(3);
    server_.send(message, "these bytes are no picture");
    ASSERT_TRUE(eventually(*connection_, [&] { return !failures.empty(); }));
    EXPECT_EQ(failures.front(), std::pair(std::uint64_t{3}, ErrorCode::corrupt));
    EXPECT_EQ(server_.read(proto::ClientMessage::kCredit).credit().frames(), 1U);
    sendFrame(4, 8);
    EXPECT_EQ(frameOf(*connection_).message.view_id(), 4U);
}

TEST_F(ConnectionTest, AFailureOfAViewNamesTheView) {
    connect();
    std::uint64_t failed = 0;
    std::string where;
    connection_->onViewFailed([&](std::uint64_t id, const Error& error) {
        failed = id;
        where = error.where;
    });
    connection_->setView(viewOfWidth(1), {});
    server_.read();
    const auto id = connection_->setView(viewOfWidth(2), {});
    proto::ServerMessage failure;
    failure.set_reply_to(server_.read().request());
    failure.mutable_failure()->set_code("not_found");
    failure.mutable_failure()->set_where("layers[0].dataset");
    failure.mutable_failure()->set_message("there is no such dataset");
    server_.send(failure);
    ASSERT_TRUE(eventually(*connection_, [&] { return failed != 0; }));
    EXPECT_EQ(failed, id);
    EXPECT_EQ(where, "layers[0].dataset");
    EXPECT_EQ(connection_->state(), State::connected);
}

TEST_F(ConnectionTest, QuestionsAreSentInOrderAndAnsweredByTheirNumber) {
    connect();
    std::string log;
    connection_->listDatasets([&](const Result<proto::Catalogue>& reply) {
        log += reply.ok() ? reply->datasets(0).name() + ";" : reply.error().message;
    });
    connection_->describe("data/a", [&](const Result<proto::Description>& reply) {
        log += reply.ok() ? reply->dataset() + ";" : reply.error().message;
    });
    const auto list = server_.read();
    const auto describe = server_.read();
    ASSERT_TRUE(list.has_list_datasets());
    ASSERT_EQ(describe.describe().dataset(), "data/a");
    proto::ServerMessage message;
    message.set_reply_to(describe.request());
    message.mutable_description()->set_dataset("described");
    server_.send(message);
    message.set_reply_to(list.request());
    message.mutable_catalogue()->add_datasets()->set_name("listed");
    server_.send(message);
    ASSERT_TRUE(eventually(*connection_, [&] { return log.size() >= 17; }));
    EXPECT_EQ(log, "described;listed;");
}

TEST_F(ConnectionTest, JobsAreSubmittedCancelledAndWatched) {
    connect();
    std::string submitted, cancelled;
    proto::JobRequest job;
    job.set_output("data/x.mote");
    connection_->submitJob(job, [&](const Result<proto::JobStatus>& reply) { submitted = reply->id(); });
    connection_->submitJob(job, [](const Result<proto::JobStatus>&) {}, {true, 60});
    connection_->cancelJob("7", [&](const Result<proto::JobStatus>& reply) {
        cancelled = reply.ok() ? "yes" : std::string(name(reply.error().code)) + " " + reply.error().where;
    });
    std::optional<proto::Jobs> all;
    connection_->watchJobs([&](const Result<proto::Jobs>& reply) { all = *reply; });
    std::vector<proto::JobStatus> news;
    connection_->onJob([&](const proto::JobStatus& status) { news.push_back(status); });

    const auto submit = server_.read();
    EXPECT_EQ(submit.submit_job().job().output(), "data/x.mote");
    EXPECT_FALSE(submit.submit_job().again());
    const auto wished = server_.read();
    EXPECT_TRUE(wished.submit_job().again());
    EXPECT_EQ(wished.submit_job().time_limit_s(), 60U);
    proto::ServerMessage message;
    message.set_reply_to(submit.request());
    message.mutable_job()->set_id("7");
    server_.send(message);
    const auto cancel = server_.read();
    EXPECT_EQ(cancel.cancel_job().id(), "7");
    message.set_reply_to(cancel.request());
    message.mutable_failure()->set_code("not_found");
    message.mutable_failure()->set_where("id");
    server_.send(message);
    message.set_reply_to(server_.read().request());
    message.mutable_jobs()->add_jobs()->set_id("7");
    server_.send(message);
    ASSERT_TRUE(eventually(*connection_, [&] { return all.has_value(); }));
    EXPECT_EQ(submitted, "7");
    EXPECT_EQ(cancelled, "not_found id");
    EXPECT_EQ(all->jobs_size(), 1);
    EXPECT_TRUE(news.empty());

    // Progress that nobody looked at in between arrives once, as it is now.
    for (const double progress : {0.25, 0.5, 0.75}) {
        proto::ServerMessage change;
        change.mutable_job()->set_id("7");
        change.mutable_job()->set_progress(progress);
        server_.send(change);
    }
    settle();
    ASSERT_FALSE(news.empty());
    EXPECT_EQ(news.back().progress(), 0.75);
}

TEST_F(ConnectionTest, NewsOfTheCatalogueIsNoAnswer) {
    connect();
    std::vector<std::string> heard;
    connection_->onCatalogue(
        [&](const proto::Catalogue& catalogue) { heard.push_back(catalogue.datasets(0).name()); });
    bool answered = false;
    connection_->listDatasets([&](const Result<proto::Catalogue>& reply) { answered = reply.ok(); });
    const auto question = server_.read();
    proto::ServerMessage news;
    news.mutable_catalogue()->add_datasets()->set_name("fresh");
    server_.send(news);
    ASSERT_TRUE(eventually(*connection_, [&] { return !heard.empty(); }));
    EXPECT_FALSE(answered);
    news.set_reply_to(question.request());
    server_.send(news);
    ASSERT_TRUE(eventually(*connection_, [&] { return answered; }));
    EXPECT_EQ(heard, std::vector<std::string>{"fresh"});
}

TEST_F(ConnectionTest, AnAnswerOfAnotherKindIsAnError) {
    connect();
    std::optional<Error> error;
    connection_->listDatasets([&](const Result<proto::Catalogue>& reply) { error = reply.error(); });
    proto::ServerMessage message;
    message.set_reply_to(server_.read().request());
    message.mutable_jobs();
    server_.send(message);
    ASSERT_TRUE(eventually(*connection_, [&] { return error.has_value(); }));
    EXPECT_EQ(error->code, ErrorCode::internal);
}

}  // namespace
}  // namespace mote::client
