// SPDX-License-Identifier: GPL-3.0-or-later
//
// Questions about few, odd or no particles, answered by the whole service: a number that is not defined is
// NaN, a count of nothing 0, and what is missing is said.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/gtc/constants.hpp>
#include <latch>

#include "server/numbers/query_service.h"
#include "storage/beam/beam_statistics.h"
#include "tests/support/memory_run.h"
#include "tests/unit/numbers/plain_selection.h"

namespace mote::test {
namespace {

using server::QueryAnswer;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

class OddRun final : public server::RunSource {
  public:
    explicit OddRun(std::shared_ptr<const storage::RunSteps> run) : run_(std::move(run)) {}
    Result<std::shared_ptr<const storage::RunSteps>> run(const std::string&) override { return run_; }

  private:
    std::shared_ptr<const storage::RunSteps> run_;
};

/// A step of particles whose x and weight are given, and whose other columns are even.
MemoryRun::Step stepOf(const std::vector<double>& x, const std::vector<double>& weights,
                       const std::optional<std::vector<std::uint64_t>>& ids = {}) {
    std::vector<WeightedPoint> points;
    for (std::size_t i = 0; i < x.size(); ++i)
        points.push_back({glm::dvec3((static_cast<double>(i) + 0.5) / static_cast<double>(x.size())), 1.0});
    MemoryRun::Step step;
    step.points = MemoryStep::make(points);
    const auto rows = step.points->rows(0, x.size());
    std::vector<MemoryColumns::Column> columns;
    for (const auto* const name : {"x", "y", "z", "px", "py", "pz", "weight"}) {
        MemoryColumns::Column column{{name, "", 0.0}, {}};
        for (const auto row : rows) {
            const bool given = column.info.name == "x" || column.info.name == "weight";
            const auto& values = column.info.name == "x" ? x : weights;
            column.values.push_back(static_cast<float>(given ? values[row] : 1.0 + static_cast<double>(row)));
        }
        columns.push_back(std::move(column));
    }
    auto own = ids;
    for (std::size_t i = 0; own && i < own->size(); ++i) (*own)[i] = (*ids)[rows[i]];
    step.columns = std::make_shared<const MemoryColumns>(x.size(), std::move(columns), std::move(own));
    return step;
}

/// The answer of the last of the steps that were asked for.
Result<QueryAnswer> ask(std::vector<MemoryRun::Step> steps, const proto::Query& query) {
    OddRun runs(std::make_shared<const MemoryRun>(std::move(steps),
                                                  BeamContext{.mass = 0.511e6, .meanMomentum = 4e6}));
    constexpr std::uint64_t memory = 256 << 20;
    server::QueryService service(runs, std::make_shared<storage::BlockBudget>(memory), memory, 1);
    std::optional<Result<QueryAnswer>> answer;
    std::latch come(1);
    service.ask(query, [&](Result<QueryAnswer> one) {
        answer = std::move(one);
        come.count_down();
    });
    come.wait();
    return *std::move(answer);
}

double statistic(const Result<QueryAnswer>& answer, const std::string& name) {
    const auto& found = answer->message.statistics();
    for (int i = 0; i < found.names_size(); ++i) {
        if (found.names(i) == name) return found.values(i);
    }
    ADD_FAILURE() << "no " << name;
    return 0.0;
}

proto::Query statisticsQuery(std::uint32_t step = 0) {
    proto::Query query;
    query.set_dataset("data/run");
    query.set_steps(std::to_string(step));
    query.mutable_statistics();
    return query;
}

proto::Query rangeQuery(double min) {
    auto query = statisticsQuery();
    auto& range = *query.mutable_select()->add_ranges();
    range.set_column("x");
    range.set_min(min);
    return query;
}

const std::vector<double> ones(5, 1.0);

TEST(OddInput, OfNoParticleNothingIsDefined) {
    for (const auto& x : {std::vector<double>{1, 2, 3, 4, 5}, std::vector<double>{}}) {
        const auto answer = ask({stepOf(x, ones)}, rangeQuery(100.0));
        ASSERT_TRUE(answer.ok()) << answer.error().toString();
        for (const auto& one : mote::statistics()) {
            const auto value = statistic(answer, one.name);
            if (one.name.starts_with("n_")) {
                EXPECT_EQ(value, 0.0) << one.name;
            } else if (one.name != "charge") {
                EXPECT_TRUE(std::isnan(value)) << one.name << " " << value;
            }
        }
        auto query = rangeQuery(100.0);
        query.mutable_histogram()->add_axes()->set_column("x");
        const auto counted = ask({stepOf(x, ones)}, query);
        ASSERT_TRUE(counted.ok()) << counted.error().toString();
        EXPECT_EQ(counted->message.histogram().particles(), 0U);
        EXPECT_EQ(counted->payload, std::vector<std::uint8_t>(counted->payload.size()));
    }
}

TEST(OddInput, OneParticleHasAPlaceAndNoSpread) {
    const auto answer = ask({stepOf({1, 2, 3, 4, 5}, ones)}, rangeQuery(4.5));
    ASSERT_TRUE(answer.ok()) << answer.error().toString();
    EXPECT_EQ(statistic(answer, "n_particle"), 1.0);
    EXPECT_EQ(statistic(answer, "mean_x"), 5.0);
    EXPECT_EQ(statistic(answer, "min_x"), 5.0);
    EXPECT_EQ(statistic(answer, "sigma_x"), 0.0);
}

TEST(OddInput, WeightsOfNothingAndBelow) {
    const std::vector<double> x{1, 2, 3, 4, 5};
    const auto none = ask({stepOf(x, {0, 0, 0, 0, 0})}, rangeQuery(2.5));
    ASSERT_TRUE(none.ok()) << none.error().toString();
    EXPECT_TRUE(std::isnan(statistic(none, "mean_x")));
    EXPECT_TRUE(std::isnan(statistic(none, "sigma_x")));
    // A particle of negative weight is in no statistic, and counts below nothing in a histogram.
    const auto below = ask({stepOf(x, {1, 1, 1, -2, 3})}, rangeQuery(2.5));
    ASSERT_TRUE(below.ok()) << below.error().toString();
    EXPECT_NEAR(statistic(below, "mean_x"), (3.0 + 3 * 5.0) / 4.0, 1e-15);
    auto query = rangeQuery(2.5);
    auto& axis = *query.mutable_histogram()->add_axes();
    axis.set_column("x");
    axis.set_bins(5);  // of the run's whole range
    const auto counted = ask({stepOf(x, {1, 1, 1, -2, 3})}, query);
    ASSERT_TRUE(counted.ok()) << counted.error().toString();
    std::vector<double> counts(counted->payload.size() / sizeof(double));
    std::memcpy(counts.data(), counted->payload.data(), counted->payload.size());
    EXPECT_EQ(counts, (std::vector<double>{0, 0, 1, -2, 3}));
}

TEST(OddInput, RowsThatAreNotANumberAreInNoRangeAndNoMoment) {
    const auto step = stepOf({1, nan, 3, nan, 5}, ones);
    const auto answer = ask({step}, rangeQuery(0.0));
    ASSERT_TRUE(answer.ok()) << answer.error().toString();
    EXPECT_EQ(statistic(answer, "n_particle"), 3.0);
    EXPECT_EQ(statistic(answer, "mean_x"), 3.0);
    // Those that are not in the range: counted, but of no moment.
    auto others = statisticsQuery();
    *others.mutable_select()->mutable_negated() = rangeQuery(0.0).select();
    const auto rest = ask({step}, others);
    ASSERT_TRUE(rest.ok()) << rest.error().toString();
    EXPECT_EQ(statistic(rest, "n_particle"), 2.0);
    EXPECT_TRUE(std::isnan(statistic(rest, "mean_y")));
}

TEST(OddInput, IdsThatRepeatOrAreNotThere) {
    // Of 7 there are two in the first step, of 9 none in the second, of 8 two there.
    const std::vector<MemoryRun::Step> steps{
        stepOf({1, 2, 3, 4}, ones, std::vector<std::uint64_t>{7, 7, 8, 9}),
        stepOf({10, 20, 30}, ones, std::vector<std::uint64_t>{8, 8, 6})};
    auto query = statisticsQuery(1);
    query.mutable_select()->set_step(0);
    auto& range = *query.mutable_select()->add_ranges();
    range.set_column("x");
    range.set_min(1.5);
    const auto followed = ask(steps, query);
    ASSERT_TRUE(followed.ok()) << followed.error().toString();
    EXPECT_EQ(statistic(followed, "n_particle"), 2.0);
    EXPECT_EQ(statistic(followed, "max_x"), 20.0);
    query = statisticsQuery(0);
    for (const std::uint64_t id : {7, 9, 6, 7}) query.mutable_select()->add_ids(id);
    const auto chosen = ask(steps, query);
    ASSERT_TRUE(chosen.ok()) << chosen.error().toString();
    EXPECT_EQ(statistic(chosen, "n_particle"), 3.0);
}

TEST(OddInput, PolygonsOfAsManyCornersAsThereMayBe) {
    Random random(1, 95);
    const auto run = anyRun(random, {.most = 3000, .steps = 1, .oddWeights = false, .odd = false});
    for (const std::size_t corners : {std::size_t{3}, Selection::maxPolygonPoints}) {
        auto query = statisticsQuery();
        auto& polygon = *query.mutable_select()->mutable_polygon();
        polygon.add_columns("x");
        polygon.add_columns("y");
        for (std::size_t i = 0; i < corners; ++i) {
            const double angle =
                glm::two_pi<double>() * static_cast<double>(i) / static_cast<double>(corners);
            auto& point = *polygon.add_points();
            const double radius = 1e-3 * random.between(0.9, 1.1);
            point.add_values()->set_number_value(radius * std::cos(angle));
            point.add_values()->set_number_value(radius * std::sin(angle));
        }
        const auto selection = parseSelection(query.select());
        ASSERT_TRUE(selection.ok());
        const auto expected = plainSelection(*selection, *run, 0);
        const auto answer = ask({run->at(0)}, query);
        ASSERT_TRUE(answer.ok()) << answer.error().toString();
        EXPECT_GT(statistic(answer, "n_particle"), 0.0);
        EXPECT_EQ(statistic(answer, "n_particle"),
                  static_cast<double>(std::ranges::count(expected, Chosen::yes)));
    }
}

TEST(OddInput, ARunWithoutColumnsSaysHowToMakeThem) {
    auto step = stepOf({1, 2, 3, 4, 5}, ones);
    step.columns = nullptr;
    const auto answer = ask({step}, rangeQuery(0.0));
    ASSERT_FALSE(answer.ok());
    EXPECT_EQ(answer.error().code, ErrorCode::notFound);
    EXPECT_NE(answer.error().message.find("mote-prep particles"), std::string::npos)
        << answer.error().toString();
}

}  // namespace
}  // namespace mote::test
