// SPDX-License-Identifier: GPL-3.0-or-later
//
// Queries: questions with several answers, that may be cancelled.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/client/connection_fixture.h"

namespace mote::client {
namespace {

using testing::ElementsAre;
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
