// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <vector>

#include "protocol/wire/framing.h"
#include "tests/unit/client/fake_server.h"

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

/// A view with a hidden layer, as a server of that minor version gets it.
proto::Layer hiddenLayerAt(Connection& connection, FakeServer& server) {
    auto view = viewOfWidth(3);
    view.add_layers()->set_hidden(true);
    view.mutable_layers(0)->set_opacity(0.5);
    connection.setView(view, {});
    return server.read().set_view().view().layers(0);
}

TEST_F(ConnectionTest, AHiddenLayerIsHidden) {
    connect(quietSettings(), 4);
    const auto layer = hiddenLayerAt(*connection_, server_);
    EXPECT_TRUE(layer.hidden());
    EXPECT_EQ(layer.opacity(), 0.5);
}

TEST_F(ConnectionTest, AServerThatKnowsNoHiddenLayersIsToldThatNothingIsThere) {
    connect(quietSettings(), 3);
    EXPECT_EQ(hiddenLayerAt(*connection_, server_).opacity(), 0.0);
}

TEST_F(ConnectionTest, AThumbnailIsAPicture) {
    connect(quietSettings(), 4);
    const auto pixels = test::samplePixels(16, 8, proto::SRGB8);
    for (const bool whole : {true, false}) {
        std::optional<Result<FramePixels>> got;
        connection_->thumbnail("data/a", [&](Result<FramePixels> reply) { got = std::move(reply); });
        const auto question = server_.read();
        EXPECT_EQ(question.get_thumbnail().dataset(), "data/a");
        proto::ServerMessage answer;
        answer.set_reply_to(question.request());
        answer.mutable_thumbnail()->set_width(16);
        answer.mutable_thumbnail()->set_height(8);
        server_.send(answer, whole ? test::jpegPayload(pixels, 16) : "no JPEG");
        ASSERT_TRUE(eventually(*connection_, [&] { return got.has_value(); }));
        ASSERT_EQ(got->ok(), whole);
        EXPECT_EQ(whole ? got->value().bytes.size() : pixels.size(), pixels.size());
    }
}

TEST_F(ConnectionTest, FilesAreAskedForAndALookIsCancelled) {
    connect(quietSettings(), filesFromMinor);
    std::optional<Result<proto::Folder>> folder;
    connection_->listFolder("data/runs", 20, [&](Result<proto::Folder> reply) { folder = std::move(reply); });
    auto question = server_.read();
    EXPECT_EQ(question.list_folder().folder(), "data/runs");
    EXPECT_EQ(question.list_folder().first(), 20U);
    proto::ServerMessage answer;
    answer.set_reply_to(question.request());
    answer.mutable_folder()->set_total(21);
    server_.send(answer);
    ASSERT_TRUE(eventually(*connection_, [&] { return folder.has_value(); }));
    EXPECT_EQ(folder->value().total(), 21U);

    proto::LookAtFile wanted;
    wanted.set_input("data/run.h5");
    bool told = false;
    const auto first = connection_->lookAtFile(wanted, [&](const Result<proto::Look>&) { told = true; });
    const auto cancelled = server_.read();
    EXPECT_EQ(cancelled.look_at_file().input(), "data/run.h5");
    connection_->cancelQuery(first);
    EXPECT_EQ(server_.read().cancel_query().request(), cancelled.request());
    std::optional<Result<proto::Look>> look;
    connection_->lookAtFile(wanted, [&](Result<proto::Look> reply) { look = std::move(reply); });
    question = server_.read();
    answer.set_reply_to(cancelled.request());
    answer.mutable_failure()->set_code("cancelled");
    server_.send(answer);
    answer.set_reply_to(question.request());
    answer.mutable_look()->set_input("data/run.h5");
    server_.send(answer);
    ASSERT_TRUE(eventually(*connection_, [&] { return look.has_value(); }));
    EXPECT_EQ(look->value().input(), "data/run.h5");
    EXPECT_FALSE(told) << "it was cancelled";

    std::optional<Result<proto::Loaded>> loaded;
    connection_->listLoaded("data/beam", [&](Result<proto::Loaded> reply) { loaded = std::move(reply); });
    question = server_.read();
    EXPECT_EQ(question.list_loaded().dataset(), "data/beam");
    answer.set_reply_to(question.request());
    answer.mutable_loaded()->add_steps(3);
    server_.send(answer);
    ASSERT_TRUE(eventually(*connection_, [&] { return loaded.has_value(); }));
    EXPECT_EQ(loaded->value().steps(0), 3U);
}

// Queued views: each is drawn and each frame is taken, in order, whatever the line does.

using testing::ElementsAre;

class ConnectionQueueTest : public ConnectionTest {
  protected:
    static constexpr std::uint32_t minor = 2;  // from which on servers keep a queue

    void connect(const ConnectionSettings& settings = quietSettings()) {
        ConnectionTest::connect(settings, minor);
    }

    std::uint64_t queue(std::uint32_t width) {
        ViewRequest request;
        request.finalOnly = true;
        request.queued = true;
        return connection_->setView(viewOfWidth(width), request);
    }

    std::uint32_t widthOfNextView() {
        const auto message = server_.read(proto::ClientMessage::kSetView).set_view();
        EXPECT_TRUE(message.queued());
        return message.view().width();
    }
};

TEST_F(ConnectionQueueTest, AllAreSentAndAllFramesAreTakenInOrder) {
    connect();
    std::vector<std::uint64_t> ids;
    for (std::uint32_t width = 1; width <= 3; ++width) ids.push_back(queue(width));
    for (std::uint32_t width = 1; width <= 3; ++width) EXPECT_EQ(widthOfNextView(), width);
    for (std::uint32_t i = 0; i < 3; ++i) sendFrame(ids[i], i + 1);
    settle();
    for (std::uint32_t i = 0; i < 3; ++i) {
        const auto frame = frameOf(*connection_);
        EXPECT_EQ(frame.message.view_id(), ids[i]);
        const auto pixels = test::samplePixels(i + 1, 4, proto::SRGB8);
        EXPECT_EQ(frame.pixels.bytes, pixels);
        const auto travelled = test::zstdPayload(pixels, i + 1, proto::SRGB8);
        EXPECT_EQ(std::string(frame.payload.begin(), frame.payload.end()), travelled);
    }
    EXPECT_FALSE(connection_->takeFrame());
}

TEST_F(ConnectionQueueTest, NoMoreAreSentThanAServerKeeps) {
    connect();
    std::vector<std::uint64_t> ids;
    for (std::uint32_t i = 1; i <= wire::maxQueuedViews + 2; ++i) ids.push_back(queue(i));
    for (std::uint32_t i = 1; i <= wire::maxQueuedViews; ++i) EXPECT_EQ(widthOfNextView(), i);
    settle();
    sendFrame(ids[0], 1);
    EXPECT_EQ(frameOf(*connection_).message.view_id(), ids[0]);
    EXPECT_EQ(widthOfNextView(), wire::maxQueuedViews + 1);
}

TEST_F(ConnectionQueueTest, AFailureLeavesTheOthers) {
    connect();
    std::vector<std::uint64_t> failed;
    connection_->onViewFailed([&](std::uint64_t id, const Error&) { failed.push_back(id); });
    const auto first = queue(1), second = queue(2);
    proto::ServerMessage failure;
    failure.set_reply_to(server_.read(proto::ClientMessage::kSetView).request());
    failure.mutable_failure()->set_code("not_found");
    server_.send(failure);
    ASSERT_TRUE(eventually(*connection_, [&] { return !failed.empty(); }));
    EXPECT_THAT(failed, ElementsAre(first));
    sendFrame(second, 2);
    EXPECT_EQ(frameOf(*connection_).message.view_id(), second);
}

TEST_F(ConnectionQueueTest, AfterALineBrokeOnlyUnansweredOnesAreAskedForAgain) {
    auto settings = quietSettings();
    settings.returnPatience = std::chrono::seconds(20);
    connect(settings);
    const auto first = queue(1), second = queue(2);
    EXPECT_EQ(widthOfNextView(), 1U);
    EXPECT_EQ(widthOfNextView(), 2U);
    sendFrame(first, 1);
    settle();
    server_.drop();
    server_.welcome(minor);
    EXPECT_EQ(widthOfNextView(), 2U);
    EXPECT_EQ(frameOf(*connection_).message.view_id(), first);  // it had arrived
    sendFrame(second, 2);
    EXPECT_EQ(frameOf(*connection_).message.view_id(), second);
    // The first one's credit was of the old line.
    std::uint32_t credits = 0;
    while (!server_.quiet()) credits += server_.read(proto::ClientMessage::kCredit).credit().frames();
    EXPECT_LE(credits, 1U);
}

TEST_F(ConnectionQueueTest, AnOlderServerGetsOneAtATime) {
    ConnectionTest::connect(quietSettings(), 1);
    const auto first = queue(1);
    queue(2);
    EXPECT_EQ(widthOfNextView(), 1U);
    settle();
    sendFrame(first, 1);
    EXPECT_EQ(frameOf(*connection_).message.view_id(), first);
    EXPECT_EQ(widthOfNextView(), 2U);
}

TEST_F(ConnectionQueueTest, AViewThatIsNotQueuedTakesTheirPlace) {
    connect();
    for (std::uint32_t i = 1; i <= wire::maxQueuedViews + 1; ++i) queue(i);
    for (std::uint32_t i = 1; i <= wire::maxQueuedViews; ++i) widthOfNextView();
    const auto id = connection_->setView(viewOfWidth(99), {});
    const auto message = server_.read(proto::ClientMessage::kSetView).set_view();
    EXPECT_FALSE(message.queued());
    EXPECT_EQ(message.view().width(), 99U);
    sendFrame(id, 99);
    EXPECT_EQ(frameOf(*connection_).message.view_id(), id);
}

// Queries: questions with several answers, that may be cancelled.

using testing::IsEmpty;

class ConnectionQueries : public ConnectionTest {
  protected:
    /// What a query was answered with: steps, or -1 of an error.
    struct Heard {
        std::vector<int> steps;
        std::optional<Error> error;
    };

    static proto::Query queryFor(const std::string& dataset) {
        proto::Query query;
        query.set_dataset(dataset);
        query.mutable_statistics();
        return query;
    }

    std::uint64_t ask(Heard& heard, const std::string& dataset = "data/beam") {
        return connection_->query(queryFor(dataset), [&heard](Result<QueryAnswer> answer) {
            if (answer.ok()) heard.steps.push_back(static_cast<int>(answer->message.step()));
            if (!answer.ok()) heard.error = answer.error();
        });
    }

    void answer(std::uint64_t request, std::uint32_t step, bool last) {
        proto::ServerMessage message;
        message.set_reply_to(request);
        message.mutable_answer()->set_step(step);
        message.mutable_answer()->set_last(last);
        server_.send(message, "12345678");
    }

    void fail(std::uint64_t request, const std::string& code) {
        proto::ServerMessage message;
        message.set_reply_to(request);
        message.mutable_failure()->set_code(code);
        message.mutable_failure()->set_message("no more");
        server_.send(message);
    }
};

TEST_F(ConnectionQueries, AreAnsweredUntilTheLast) {
    connect();
    Heard one, two;
    ask(one);
    ask(two, "data/other");
    const auto first = server_.read(), second = server_.read();
    EXPECT_EQ(second.query().dataset(), "data/other");
    for (std::uint32_t step = 0; step < 5; ++step) {
        answer(second.request(), 10 + step, step == 4);
        answer(first.request(), step, step == 4);
    }
    answer(first.request(), 99, true);  // nobody asked
    settle();
    EXPECT_THAT(one.steps, ElementsAre(0, 1, 2, 3, 4));
    EXPECT_THAT(two.steps, ElementsAre(10, 11, 12, 13, 14));
    EXPECT_FALSE(one.error || two.error);
}

TEST_F(ConnectionQueries, EndWithAFailure) {
    connect();
    Heard heard;
    ask(heard);
    const auto request = server_.read().request();
    answer(request, 0, false);
    fail(request, "corrupt");
    answer(request, 1, true);
    settle();
    EXPECT_THAT(heard.steps, ElementsAre(0));
    ASSERT_TRUE(heard.error);
    EXPECT_EQ(heard.error->code, ErrorCode::corrupt);
}

TEST_F(ConnectionQueries, AnotherAnswerIsAnError) {
    connect();
    Heard heard;
    ask(heard);
    proto::ServerMessage message;
    message.set_reply_to(server_.read().request());
    message.mutable_jobs();
    server_.send(message);
    settle();
    EXPECT_TRUE(heard.error);
}

TEST_F(ConnectionQueries, CancelledOnesAreSilent) {
    connect();
    std::vector<std::string> complaints;
    connection_->onViewFailed(
        [&](std::uint64_t, const Error& error) { complaints.push_back(error.message); });
    for (const bool failing : {false, true}) {
        Heard heard;
        const auto query = ask(heard);
        const auto request = server_.read().request();
        answer(request, 0, false);
        // What has arrived and was not told yet is not told any more.
        while (!connection_->wait(std::chrono::milliseconds(100))) {
        }
        connection_->cancelQuery(query);
        const auto cancel = server_.read();
        ASSERT_TRUE(cancel.has_cancel_query());
        EXPECT_EQ(cancel.cancel_query().request(), request);
        answer(request, 1, !failing);
        if (failing) fail(request, "cancelled");
        settle();
        connection_->cancelQuery(query);
        settle();
        EXPECT_THAT(heard.steps, IsEmpty());
        EXPECT_FALSE(heard.error);
    }
    EXPECT_THAT(complaints, IsEmpty());
}

TEST_F(ConnectionQueries, OneThatWasNotSentIsNeverSent) {
    connection_.emplace(server_.connectionFile(), quietSettings());
    Heard kept, dropped;
    const auto query = ask(dropped, "data/dropped");
    ask(kept, "data/kept");
    connection_->cancelQuery(query);
    server_.welcome();
    EXPECT_EQ(server_.read().query().dataset(), "data/kept");
    settle();
    EXPECT_TRUE(server_.quiet());
}

TEST_F(ConnectionQueries, AreAskedAgainOnANewLineUnlessTheyWereAnsweredInPart) {
    auto settings = quietSettings();
    settings.returnPatience = std::chrono::seconds(20);
    connect(settings);
    Heard partly, fresh;
    ask(partly, "data/partly");
    ask(fresh, "data/fresh");
    answer(server_.read().request(), 0, false);
    server_.read();
    settle();
    server_.drop();
    server_.welcome();
    const auto again = server_.read();
    EXPECT_EQ(again.query().dataset(), "data/fresh");
    answer(again.request(), 7, true);
    settle();
    EXPECT_THAT(partly.steps, ElementsAre(0));
    EXPECT_TRUE(partly.error);
    EXPECT_THAT(fresh.steps, ElementsAre(7));
    EXPECT_FALSE(fresh.error);
}

}  // namespace
}  // namespace mote::client
