// SPDX-License-Identifier: GPL-3.0-or-later
//
// Queries of clients: answered a step at a time, cancelled, left behind, and no more at once than may be.
#include <google/protobuf/util/json_util.h>

#include <cstring>

#include "server/session/session_queries.h"
#include "tests/support/random.h"
#include "tests/unit/particles/job_run.h"
#include "tests/unit/session/session_fixture.h"

namespace mote::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

proto::ClientMessage queryOf(const std::string& json) {
    proto::ClientMessage message;
    const auto read = google::protobuf::util::JsonStringToMessage(json, message.mutable_query());
    EXPECT_TRUE(read.ok()) << read.ToString();
    return message;
}

/// Of the dataset's three steps.
const std::string quick = R"({"dataset": "data/few.mote", "histogram": {"axes": [{"column": "x"}]}})";

class SessionNumbers : public SessionFixture {
  protected:
    /// Few particles in three steps, and many in one.
    void startWithData() {
        std::vector<FakeStep> steps;
        for (std::size_t i = 0; i < 3; ++i) {
            steps.push_back(beamStep(1000 + 500 * i, i));
            steps.back().iteration = static_cast<std::int64_t>(10 * i);
        }
        FakeSource few(std::move(steps));
        ASSERT_TRUE(make(requestFor(), few, folder_ / "data/few.mote").ok());
        FakeSource many({beamStep(300000, 9)});
        ASSERT_TRUE(make(requestFor(), many, folder_ / "data/many.mote").ok());
        start();
    }

    /// A question of many seconds (7 on two cores): a far corner leaves all edges to be tried at each
    /// particle.
    static proto::ClientMessage slowQuery(std::uint64_t request) {
        auto message = queryOf(R"({"dataset": "data/many.mote", "histogram": {"axes": [{"column": "x"}]},
                                   "select": {"polygon": {"columns": ["x", "y"]}}})");
        Random random(request, 93);
        for (int i = 0; i < 10000; ++i) {
            auto& point = *message.mutable_query()->mutable_select()->mutable_polygon()->add_points();
            const double far = i == 0 ? 1e9 : 1.0;
            point.add_values()->set_number_value(far * random.between(-1e-3, 1e-3));
            point.add_values()->set_number_value(far * (i % 2 == 0 ? -1.0 : 1.0));
        }
        message.set_request(request);
        return message;
    }

    static proto::ClientMessage quickQuery(std::uint64_t request) {
        auto message = queryOf(quick);
        message.set_request(request);
        return message;
    }

    static proto::ClientMessage cancelOf(std::uint64_t request) {
        proto::ClientMessage message;
        message.mutable_cancel_query()->set_request(request);
        return message;
    }

    /// To whichever request; a catalogue that has changed is told in between.
    static proto::ServerMessage nextReply(TestClient& client) {
        return client.receive([](const proto::ServerMessage& message) { return message.reply_to() != 0; })
            .message;
    }

    static void expectCancelled(TestClient& client, std::uint64_t request) {
        const auto reply = client.receiveReply(request).message;
        EXPECT_EQ(reply.failure().code(), "cancelled") << reply.ShortDebugString();
        EXPECT_EQ(reply.failure().where(), "query");
        EXPECT_FALSE(reply.failure().fatal());
    }
};

TEST_F(SessionNumbers, AnswersComeAStepAtATime) {
    startWithData();
    const auto asker = client();
    for (const auto& [chosen, steps] : std::initializer_list<std::pair<const char*, std::vector<unsigned>>>{
             {"", {0, 1, 2}}, {"0:2:2", {0, 2}}, {"1", {1}}}) {
        auto message = queryOf(quick);
        message.mutable_query()->set_steps(chosen);
        message.set_request(1000 + steps.size());
        ASSERT_TRUE(asker->send(message));
        for (const auto step : steps) {
            const auto received = asker->receiveReply(message.request());
            ASSERT_TRUE(received.message.has_answer()) << received.message.ShortDebugString();
            const auto& answer = received.message.answer();
            EXPECT_EQ(answer.step(), step);
            EXPECT_EQ(answer.iteration(), 10 * step);
            EXPECT_EQ(answer.last(), step == steps.back());
            std::vector<double> counts(received.payload.size() / sizeof(double));
            std::memcpy(counts.data(), received.payload.data(), counts.size() * sizeof(double));
            double sum = 0.0;
            for (const double count : counts) sum += count;
            const auto particles = 1000.0 + 500.0 * step;
            EXPECT_EQ(answer.histogram().particles(), 1000 + 500 * step);
            EXPECT_NEAR(sum, particles, 0.1 * particles) << "weights are about 1";
        }
    }
}

TEST_F(SessionNumbers, ACancelledQueryEndsWithAFailure) {
    startWithData();
    const auto asker = client();
    for (std::uint64_t request = 1001; request <= 1006; ++request)  // four at work, two that wait
        ASSERT_TRUE(asker->send(slowQuery(request)));
    asker->barrier();
    for (const std::uint64_t request : {1006, 1001, 1003, 1002, 1005, 1004}) {
        ASSERT_TRUE(asker->send(cancelOf(request)));
        expectCancelled(*asker, request);
    }
    // There is nothing to end any more, nor of a query that never was.
    for (const std::uint64_t request : {1001, 7}) ASSERT_TRUE(asker->send(cancelOf(request)));
    const auto asked = Clock::now();
    EXPECT_TRUE(asker->ask(queryOf(quick)).message.has_answer());
    EXPECT_LT(Clock::now() - asked, 5s) << "no thread is busy with what was cancelled";
}

TEST_F(SessionNumbers, WhoLeavesStopsItsQueries) {
    startWithData();
    const auto stays = client();
    const auto threads = server::queryThreads(std::thread::hardware_concurrency());
    std::vector<std::unique_ptr<TestClient>> leaving;
    for (unsigned asked = 0; asked < threads; asked += server::SessionQueries::mostAtWork) {
        leaving.push_back(client());
        for (std::uint64_t i = 0; i < server::SessionQueries::mostAtWork; ++i)
            ASSERT_TRUE(leaving.back()->send(slowQuery(1000 + asked + i)));
        leaving.back()->barrier();
    }
    // All threads are busy, and would be for long, until those who asked have left.
    auto message = queryOf(quick);
    message.set_request(1000);
    ASSERT_TRUE(stays->send(message));
    std::this_thread::sleep_for(300ms);
    stays->barrier();  // skips an answer, so that none would come below
    const auto left = Clock::now();
    leaving.clear();
    EXPECT_TRUE(stays->receiveReply(1000).message.has_answer());
    EXPECT_LT(Clock::now() - left, 2s);
    RecordProperty("ms", static_cast<int>((Clock::now() - left) / 1ms));
}

TEST_F(SessionNumbers, NoMoreWaitThanMay) {
    startWithData();
    const auto asker = client();
    constexpr std::uint64_t first = 1000, atWork = server::SessionQueries::mostAtWork,
                            last = first + atWork + server::SessionQueries::mostWaiting - 1;
    for (auto request = first; request <= last; ++request)
        ASSERT_TRUE(asker->send(request < first + atWork ? slowQuery(request) : quickQuery(request)));
    ASSERT_TRUE(asker->send(quickQuery(last + 1)));
    const auto refused = nextReply(*asker);
    EXPECT_EQ(refused.reply_to(), last + 1) << "those before wait";
    EXPECT_EQ(refused.failure().code(), "resource_exhausted") << refused.ShortDebugString();
    EXPECT_EQ(refused.failure().where(), "query");
    EXPECT_EQ(refused.failure().message(),
              "at most 64 queries of a client wait, and all take 16 MiB in memory; ask again when some are "
              "answered");
    EXPECT_FALSE(refused.failure().fatal());
    // Where one made room another waits, but not under a number that is taken.
    ASSERT_TRUE(asker->send(cancelOf(last)));
    expectCancelled(*asker, last);
    ASSERT_TRUE(asker->send(quickQuery(first)));
    const auto same = nextReply(*asker);
    EXPECT_EQ(same.reply_to(), first);
    EXPECT_EQ(same.failure().code(), "invalid_argument") << same.ShortDebugString();
    EXPECT_EQ(same.failure().where(), "request");
    ASSERT_TRUE(asker->send(quickQuery(last + 1)));
    for (auto request = first; request < first + atWork; ++request) {
        ASSERT_TRUE(asker->send(cancelOf(request)));
        expectCancelled(*asker, request);
    }
    EXPECT_TRUE(asker->receiveReply(last + 1).message.has_answer());
}

TEST_F(SessionNumbers, MessagesThatWaitAreBoundedToo) {
    startWithData();
    const auto asker = client();
    for (std::uint64_t i = 0; i < server::SessionQueries::mostAtWork; ++i)
        ASSERT_TRUE(asker->send(slowQuery(1000 + i)));
    // Those at work take more than a MiB each, and these nearly one: of twenty not all find room.
    auto large = quickQuery(0);
    auto& ids = *large.mutable_query()->mutable_select()->mutable_ids();
    ids.Resize(104000, ~std::uint64_t{0});  // of ten bytes
    ASSERT_LT(large.ByteSizeLong(), std::size_t{1} << 20);
    for (std::uint64_t i = 0; i < 20; ++i) {
        large.set_request(2000 + i);
        ASSERT_TRUE(asker->send(large));
    }
    const auto refused = nextReply(*asker);
    EXPECT_GT(refused.reply_to(), 2004U);
    EXPECT_LT(refused.reply_to(), 2016U);
    EXPECT_EQ(refused.failure().code(), "resource_exhausted") << refused.ShortDebugString();
    EXPECT_NE(refused.failure().message().find("take 16 MiB"), std::string::npos);
}

}  // namespace
}  // namespace mote::test
