// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/numbers/query_service.h"

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>

#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include "tests/support/memory_run.h"

namespace mote::test {
namespace {

using server::QueryAnswer;
using server::QueryService;
using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class OneRun final : public server::RunSource {
  public:
    explicit OneRun(std::shared_ptr<const storage::RunSteps> run) : run_(std::move(run)) {}
    Result<std::shared_ptr<const storage::RunSteps>> run(const std::string& dataset) override {
        if (dataset != "data/run") return Error{ErrorCode::notFound, "dataset", "is not here"};
        return run_;
    }

  private:
    std::shared_ptr<const storage::RunSteps> run_;
};

proto::Query queryOf(const std::string& json) {
    proto::Query query;
    EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(json, &query).ok());
    return query;
}

/// Takes answers as they come.
struct Taker {
    QueryService::Answered answered() {
        return [this](Result<QueryAnswer> answer) {
            const std::lock_guard lock(mutex);
            answers.push_back(std::move(answer));
            came.notify_all();
        };
    }
    /// The next answer, or nothing after so long.
    std::optional<Result<QueryAnswer>> next(std::chrono::milliseconds patience = 20s) {
        std::unique_lock lock(mutex);
        if (!came.wait_for(lock, patience, [&] { return taken < answers.size(); })) return std::nullopt;
        return std::move(answers[taken++]);
    }

    std::mutex mutex;
    std::condition_variable came;
    std::deque<Result<QueryAnswer>> answers;
    std::size_t taken = 0;
};

class QueryServiceTest : public testing::Test {
  protected:
    QueryServiceTest() {
        Random random(1, 91);
        do {
            run_ = anyRun(random, {.most = 400000, .steps = 2, .odd = false});
        } while (run_->at(0).points->pointCount() < 150000 || run_->at(1).points->pointCount() < 150000);
        runs_ = std::make_unique<OneRun>(run_);
    }
    std::unique_ptr<QueryService> serve(std::uint64_t memory) {
        return std::make_unique<QueryService>(*runs_, std::make_shared<storage::BlockBudget>(memory), memory,
                                              1);
    }

    std::shared_ptr<const MemoryRun> run_;
    std::unique_ptr<OneRun> runs_;
    Taker taker_;
};

TEST_F(QueryServiceTest, AnswersStepByStepWhenItIsToldTo) {
    const auto service = serve(64 << 20);
    const auto ticket = service->ask(
        queryOf(R"({"dataset": "data/run", "histogram": {"axes": [{"column": "x"}]}})"), taker_.answered());
    for (std::uint32_t step = 0; step < 2; ++step) {
        auto answer = taker_.next();
        ASSERT_TRUE(answer && answer->ok());
        EXPECT_EQ((*answer)->message.step(), step);
        EXPECT_EQ((*answer)->message.iteration(), 10 * step);
        EXPECT_EQ((*answer)->message.last(), step == 1);
        EXPECT_EQ((*answer)->payload.size(), 800U);
        EXPECT_FALSE(taker_.next(20ms).has_value()) << "nothing comes unasked";
        if (step == 0) service->proceed(ticket);
    }
    EXPECT_EQ(service->underWay(), 0U);
}

TEST_F(QueryServiceTest, SaysWhatIsWrong) {
    const auto service = serve(64 << 20);
    for (const auto& [json, where] : std::initializer_list<std::pair<const char*, const char*>>{
             {R"({"dataset": "data/none", "statistics": {}})", "query.dataset"},
             {R"({"dataset": "data/run"})", "query"},
             {R"({"dataset": "data/run", "steps": "2", "statistics": {}})", "query.steps"},
             {R"({"dataset": "data/run", "columns": {}})", "query.columns.names"},
             {R"({"dataset": "data/run", "histogram": {"axes": [{"column": "x", "bins": 4097}]}})",
              "query.histogram.axes[0].bins"},
             {R"({"dataset": "data/run", "histogram": {"axes": [{"column": "x"}, {"column": "n"}]}})",
              "axes[1].column"},
             {R"({"dataset": "data/run", "select": {"ids": []}, "columns": {"names": ["q"]}})", "names[0]"},
             {R"({"dataset": "data/run", "statistics": {"slices": "x", "sliceCount": 257}})",
              "query.statistics.sliceCount"}}) {
        service->ask(queryOf(json), taker_.answered());
        auto answer = taker_.next();
        ASSERT_TRUE(answer && !answer->ok()) << json;
        EXPECT_EQ(answer->error().where, where) << json;
    }
}

TEST_F(QueryServiceTest, CountsByTheDensityOfLeaves) {
    const auto service = serve(64 << 20);
    const auto countsOf = [&](const std::string& select) {
        service->ask(
            queryOf(R"({"dataset": "data/run", "steps": "0", "histogram": {"unweighted": true, "axes": )"
                    R"([{"column": "leaf_density", "bins": 16}]}, "select": )" +
                    select + "}"),
            taker_.answered());
        auto answer = taker_.next();
        std::vector<double> counts(16);
        if (!answer || !answer->ok()) {
            ADD_FAILURE() << select << (answer ? answer->error().toString() : "");
            return counts;
        }
        EXPECT_EQ((*answer)->message.histogram().axes(0).values(16), 1.0);
        std::memcpy(counts.data(), (*answer)->payload.data(), sizeof(double) * counts.size());
        return counts;
    };
    const auto& points = *run_->at(0).points;
    const auto leaves = points.leaves();
    std::vector<double> all(16);
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const double t = points.logDensity().ofLeaf(static_cast<double>(leaves.density[i]));
        all[std::min<std::size_t>(static_cast<std::size_t>(16.0 * t), 15)] += leaves.pointCount[i];
    }
    EXPECT_EQ(countsOf("{}"), all);
    // Selections by density are the same bins; what is left out of one is in the other.
    auto upper = all;
    std::fill(upper.begin(), upper.begin() + 8, 0.0);
    EXPECT_EQ(countsOf(R"({"density": {"min": 0.5, "max": 1}})"), upper);
    const auto left = countsOf(R"({"ranges": [{"column": "x", "max": 0}]})"),
               right = countsOf(R"({"not": {"ranges": [{"column": "x", "max": 0}]}})");
    for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(left[i] + right[i], all[i]);
}

/// A column x of floats about 0: half of the points lie within 1e-6 of 1, the others of -1.
std::shared_ptr<const MemoryRun> twoBunches(std::uint64_t points) {
    Random random(5, 93);
    std::vector<WeightedPoint> places(points, WeightedPoint{{0.5, 0.5, 0.5}, 1.0});
    MemoryColumns::Column x, weight;
    x.info.name = "x";
    x.info.unit = "m";
    weight.info.name = "weight";
    weight.values.assign(points, 1.0F);
    for (std::uint64_t i = 0; i < points; ++i)
        x.values.push_back(static_cast<float>((i % 2 == 0 ? 1.0 : -1.0) + random.between(-1e-6, 1e-6)));
    MemoryRun::Step step;
    step.points = MemoryStep::make(places);
    std::vector<MemoryColumns::Column> columns;
    columns.push_back(std::move(x));
    columns.push_back(std::move(weight));
    step.columns = std::make_shared<MemoryColumns>(points, std::move(columns), std::nullopt);
    std::vector<MemoryRun::Step> steps;
    steps.push_back(std::move(step));
    return std::make_shared<MemoryRun>(std::move(steps), BeamContext{});
}

TEST(QueryNotes, SayWhereAColumnIsHeldTooCoarsely) {
    OneRun runs(twoBunches(1000));
    QueryService service(runs, std::make_shared<storage::BlockBudget>(64 << 20), 64 << 20, 1);
    const auto notes = [&](const std::string& json) {
        Taker taker;
        service.ask(queryOf(R"({"dataset": "data/run", )" + json + "}"), taker.answered());
        auto answer = taker.next();
        if (!answer || !answer->ok()) {
            ADD_FAILURE() << json << (answer ? answer->error().toString() : "");
            return std::vector<std::string>();
        }
        std::vector<std::string> said((*answer)->message.notes().begin(), (*answer)->message.notes().end());
        return said;
    };
    const std::string one = R"("select": {"ranges": [{"column": "x", "min": 0}]}, )";
    EXPECT_THAT(notes(R"("statistics": {})"), IsEmpty()) << "both bunches together are wide";
    EXPECT_THAT(notes(one + R"("statistics": {})"),
                ElementsAre(HasSubstr("x is held in steps of 1.2e-07 m")));
    EXPECT_THAT(notes(one + R"("statistics": {"names": ["sigma_x"]})"), SizeIs(1));
    EXPECT_THAT(notes(one + R"("statistics": {"names": ["charge"]})"), IsEmpty()) << "not made of x";
    EXPECT_THAT(notes(R"("statistics": {"slices": "x", "sliceCount": 2})"),
                ElementsAre(HasSubstr("of a slice")));
    EXPECT_THAT(notes(R"("histogram": {"axes": [{"column": "x", "bins": 100}]})"), IsEmpty());
    EXPECT_THAT(
        notes(R"("histogram": {"axes": [{"column": "x", "bins": 100, "range": [0.999999, 1.000001]}]})"),
        ElementsAre(HasSubstr("neighbouring bins differ")));
    EXPECT_THAT(notes(R"("columns": {"names": ["x"]})"), IsEmpty());
    EXPECT_THAT(notes(one + R"("columns": {"names": ["weight", "x"]})"),
                ElementsAre(HasSubstr("fewer than 100")));
    EXPECT_THAT(notes(one + R"("figure": {"format": "PNG", "statistics": ["sigma_x"]})"), SizeIs(1));
}

TEST_F(QueryServiceTest, StopsSoon) {
    const auto service = serve(256 << 20);
    // A star of 10^5 corners: each point of the run is tried against hundreds of edges.
    proto::Query query = queryOf(
        R"({"dataset": "data/run", "histogram": {"axes": [{"column": "x"}]}, "select": {"polygon": {"columns": ["x", "y"]}}})");
    Random random(3, 92);
    for (int i = 0; i < 20000; ++i) {
        auto& point = *query.mutable_select()->mutable_polygon()->add_points();
        for (int k = 0; k < 2; ++k) point.add_values()->set_number_value(random.between(-2e-3, 2e-3));
    }
    const auto ticket = service->ask(query, taker_.answered());
    Taker later;  // one thread answers: this one waits for the first
    const auto waiting = service->ask(query, later.answered());
    std::this_thread::sleep_for(50ms);
    service->cancel(waiting);
    if (taker_.next(0ms)) GTEST_SKIP() << "this machine is too fast for it";
    service->cancel(ticket);
    const auto asked = std::chrono::steady_clock::now();
    while (service->underWay() > 0 && std::chrono::steady_clock::now() - asked < 60s)
        std::this_thread::sleep_for(1ms);
    EXPECT_EQ(service->underWay(), 0U);
    RecordProperty("ms", static_cast<int>((std::chrono::steady_clock::now() - asked) / 1ms));
    EXPECT_FALSE(later.next(0ms).has_value()) << "nothing comes of what was cancelled";
}

TEST_F(QueryServiceTest, MemoryIsBounded) {
    const auto budget = std::make_shared<storage::BlockBudget>(64 << 20);
    QueryService service(*runs_, budget, 4 << 20, 1);
    service.ask(queryOf(R"({"dataset": "data/run",
        "histogram": {"axes": [{"column": "x", "bins": 4096}, {"column": "y", "bins": 4096}]}})"),
                taker_.answered());
    auto refused = taker_.next();
    ASSERT_TRUE(refused && !refused->ok());
    EXPECT_EQ(refused->error().code, ErrorCode::resourceExhausted);
    EXPECT_NE(refused->error().message.find("--memory"), std::string::npos);
    // What is kept of selections stays within it, however many there are.
    for (int i = 0; i < 200; ++i) {
        service.ask(queryOf(R"({"dataset": "data/run", "steps": "0", "histogram": {"axes": [{"column": "x"}]},
            "select": {"ranges": [{"column": "x", "max": )" +
                            std::to_string(1e-5 * i) + "}]}}"),
                    taker_.answered());
        auto answer = taker_.next();
        ASSERT_TRUE(answer && answer->ok()) << answer->error().toString();
        EXPECT_LE(budget->resident(), std::uint64_t{5} << 20);
    }
}

TEST_F(QueryServiceTest, EndsWhileItWorks) {
    auto service = serve(256 << 20);
    for (int i = 0; i < 50; ++i)
        service->ask(queryOf(R"({"dataset": "data/run", "statistics": {"slices": "z"}})"), taker_.answered());
    service = nullptr;
    SUCCEED();
}

}  // namespace
}  // namespace mote::test
