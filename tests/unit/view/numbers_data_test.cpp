// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "client/view/numbers/histogram_view.h"
#include "client/view/numbers/numbers_data.h"
#include "client/view/numbers/plot_frame.h"
#include "client/view/numbers/quantities.h"
#include "client/view/numbers/selection_edits.h"
#include "tests/support/random.h"

namespace mote::client {
namespace {

/// A server that answers when it is told to.
class Line {
  public:
    QueryLine line() {
        return {[this](const proto::Query& query, QueryLine::Reply reply) {
                    open[++last] = {query, std::move(reply)};
                    return last;
                },
                [this](std::uint64_t request) { cancelled.insert(request); }};
    }
    struct Open {
        proto::Query query;
        QueryLine::Reply reply;
    };
    std::map<std::uint64_t, Open> open;
    std::set<std::uint64_t> cancelled;
    std::uint64_t last = 0;
};

QueryAnswer statistics(std::uint32_t step, double value, bool last = true) {
    QueryAnswer answer;
    answer.message.set_step(step);
    answer.message.set_last(last);
    answer.message.mutable_statistics()->add_names("sigma_x");
    answer.message.mutable_statistics()->add_values(value);
    return answer;
}

NumbersWanted wantedAt(std::uint32_t step, double bound) {
    NumbersWanted wanted{"data/beam", step};
    wanted.selection.emplace();
    wanted.selection->add_ranges()->set_column("x");
    wanted.selection->mutable_ranges(0)->set_min(bound);
    return wanted;
}

TEST(NumbersData, TheLatestQuestionWins) {
    Line line;
    NumbersData data(line.line());
    data.want(wantedAt(0, 1.0));
    data.want(wantedAt(0, 1.0));
    EXPECT_EQ(line.last, 1U);
    EXPECT_TRUE(data.selected().waits);
    data.want(wantedAt(1, 1.0));
    EXPECT_EQ(line.last, 2U);
    EXPECT_EQ(line.cancelled, std::set<std::uint64_t>{1});
    line.open[1].reply(statistics(0, 7.0));  // too late
    EXPECT_FALSE(data.selected().value.has_value());
    line.open[2].reply(statistics(1, 8.0));
    EXPECT_EQ(data.selected().value->values.front(), 8.0);
    EXPECT_FALSE(data.selected().waits);
    // While the next is awaited the last one stays, and says its step.
    data.want(wantedAt(2, 1.0));
    EXPECT_EQ(data.selected().value->step, 1U);
    EXPECT_TRUE(data.selected().waits);
    EXPECT_EQ(line.cancelled.size(), 1U);
}

TEST(NumbersData, AFailureIsSaidAndNotAskedForAgain) {
    Line line;
    NumbersData data(line.line());
    data.want(wantedAt(0, 1.0));
    line.open[1].reply(Error{ErrorCode::notFound, "ranges[0].column", "there is no x"});
    EXPECT_EQ(data.selected().failure, "ranges[0].column: there is no x");
    data.want(wantedAt(0, 1.0));
    EXPECT_EQ(line.last, 1U);
    data.forget();
    data.want(wantedAt(0, 1.0));
    EXPECT_EQ(line.last, 2U);
}

TEST(NumbersData, AStepWithoutStatisticsIsAskedForWhole) {
    Line line;
    NumbersData data(line.line());
    NumbersWanted wanted{"data/beam", 2};
    wanted.whole = true;
    data.want(wanted);
    ASSERT_EQ(line.last, 1U);
    EXPECT_FALSE(line.open[1].query.has_select());
    line.open[1].reply(statistics(2, 3.0));
    EXPECT_EQ(data.whole().value->values.front(), 3.0);
    wanted.whole = false;
    data.want(wanted);
    EXPECT_FALSE(data.whole().value.has_value());
}

TEST(NumbersData, ASeriesGrowsStepByStepAndWaitsForTheHand) {
    Line line;
    NumbersData data(line.line());
    auto wanted = wantedAt(0, 1.0);
    wanted.series = "sigma_x";
    wanted.moving = true;
    data.want(wanted);
    EXPECT_EQ(line.last, 1U);
    wanted.moving = false;
    data.want(wanted);
    ASSERT_EQ(line.last, 2U);
    EXPECT_EQ(line.open[2].query.steps(), "");
    line.open[2].reply(statistics(2, 5.0, false));
    EXPECT_TRUE(data.series().waits);
    line.open[2].reply(statistics(0xffffffffU, 5.0, false));  // no run is as long
    line.open[2].reply(statistics(0, 4.0));
    ASSERT_EQ(data.series().value->size(), 3U);
    EXPECT_EQ(data.series().value->at(0), 4.0);
    EXPECT_TRUE(std::isnan(data.series().value->at(1)));
    EXPECT_FALSE(data.series().waits);
}

TEST(NumbersData, AHistogramIsHeldToWhatWasAsked) {
    Line line;
    NumbersData data(line.line());
    NumbersWanted wanted{"data/beam", 3};
    wanted.histogram.emplace();
    for (const char* column : {"x", "px"}) {
        wanted.histogram->add_axes()->set_column(column);
        wanted.histogram->mutable_axes(wanted.histogram->axes_size() - 1)->set_bins(2);
    }
    data.want(wanted);
    QueryAnswer answer;
    answer.message.set_step(3);
    answer.message.set_last(true);
    for (int axis = 0; axis < 2; ++axis) {
        auto& edges = *answer.message.mutable_histogram()->add_axes();
        for (const double edge : {0.0, 1.0, 2.0}) edges.add_values(edge);
    }
    answer.payload.resize(31);
    line.open[1].reply(answer);
    EXPECT_FALSE(data.histogram().failure.empty());
    data.forget();
    data.want(wanted);
    answer.payload.resize(32);
    line.open[2].reply(answer);
    EXPECT_EQ(data.histogram().value->counts.size(), 4U);
    wanted.dataset = "data/other";
    data.want(wanted);
    EXPECT_FALSE(data.histogram().value.has_value());
}

TEST(NumbersData, WhatIsGoneIsAskedNoMore) {
    Line line;
    {
        NumbersData data(line.line());
        data.want(wantedAt(0, 1.0));
    }
    EXPECT_EQ(line.cancelled, std::set<std::uint64_t>{1});
}

TEST(NumbersData, APickedPointIsCheckedOrThereIsNone) {
    Line line;
    NumbersData data(line.line());
    proto::PickQuery place;
    place.mutable_view()->add_layers()->set_dataset("data/beam");
    data.pick(place);
    QueryAnswer answer;
    answer.message.set_last(true);
    answer.message.mutable_picked();
    line.open[1].reply(answer);
    ASSERT_TRUE(data.picked().value.has_value());
    EXPECT_FALSE(data.picked().value->has_value());
    auto& picked = *answer.message.mutable_picked();
    picked.set_found(true);
    for (int i = 0; i < 3; ++i) picked.add_position(0.5);
    picked.add_names("x");
    data.pick(place);  // the same place once more
    line.open[2].reply(answer);
    EXPECT_FALSE(data.picked().failure.empty());
    picked.add_units("m");
    picked.add_values(1e-3);
    data.pick(place);
    line.open[3].reply(answer);
    ASSERT_TRUE(data.picked().value && *data.picked().value);
    EXPECT_EQ((*data.picked().value)->values.front().unit, "m");
    picked.set_layer(1);
    data.pick(place);
    line.open[4].reply(answer);
    EXPECT_FALSE(data.picked().failure.empty());
}

using test::Random;

TEST(PlotTicks, AreRoundApartAndToldApart) {
    Random random(11);
    for (int i = 0; i < 3000; ++i) {
        const double low = random.sign() * random.magnitude(-60, 60);
        const double extent = std::abs(low) * random.magnitude(-12, 20);
        const Interval axis{low, low + extent};
        const int most = 1 + static_cast<int>(random.below(12));
        const auto ticks = ticksOf(axis, random.oneOf({"m", "eV/c", "1", "m^2"}), most);
        ASSERT_EQ(ticks.labels.size(), ticks.at.size());
        ASSERT_LE(ticks.at.size(), static_cast<std::size_t>(most) + 1);
        for (std::size_t k = 0; k < ticks.at.size(); ++k) {
            ASSERT_GE(ticks.at[k], axis.low);
            ASSERT_LE(ticks.at[k], axis.high);
            if (k > 0) {
                ASSERT_GT(ticks.at[k], ticks.at[k - 1]);
            }
        }
        const std::set<std::string> labels(ticks.labels.begin(), ticks.labels.end());
        ASSERT_EQ(labels.size(), ticks.labels.size()) << axis.low << " " << axis.high;
    }
    const double infinite = std::numeric_limits<double>::infinity();
    for (const Interval& axis :
         {Interval{1.0, 1.0}, Interval{0.0, infinite}, Interval{NAN, 1.0}, Interval{2.0, 1.0}})
        EXPECT_TRUE(ticksOf(axis, "m", 5).at.empty());
    const auto small = ticksOf({-0.0031, 0.0042}, "m", 5);
    EXPECT_EQ(small.unit, "mm");
    EXPECT_EQ(small.labels, (std::vector<std::string>{"-2", "0", "2", "4"}));
}

StepHistogram anyHistogram(Random& random, std::size_t width, std::size_t height) {
    StepHistogram histogram;
    histogram.columns = {"x", "px"};
    for (const auto bins : {width, height}) {
        auto& edges = histogram.edges.emplace_back(bins + 1);
        std::iota(edges.begin(), edges.end(), 0.0);
    }
    for (std::size_t i = 0; i < width * height; ++i)
        histogram.counts.push_back(random.oneOf({0.0, -1.0, 1.0, random.magnitude(-30, 30)}));
    return histogram;
}

TEST(HistogramPicture, EachBinHasItsPlaceAndMoreIsFurtherInTheMap) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        Random random(seed);
        const std::size_t width = 1 + random.below(9), height = 1 + random.below(9);
        const auto histogram = anyHistogram(random, width, height);
        const auto grey = ColorMap::find("viridis").value();
        const auto picture = pictureOf(histogram, grey, random.chance(0.5));
        ASSERT_EQ(picture.pixels.size(), 4 * width * height);
        const double most = *std::max_element(histogram.counts.begin(), histogram.counts.end());
        for (std::size_t x = 0; x < width; ++x) {
            for (std::size_t y = 0; y < height; ++y) {
                const double count = histogram.counts[x * height + y];
                const auto* pixel = &picture.pixels[4 * ((height - 1 - y) * width + x)];
                ASSERT_EQ(pixel[3], count > 0.0 ? 255 : 0);
                // The end of the map is yellow.
                if (count > 0.0 && count == most) {
                    ASSERT_GT(pixel[0], 250);
                }
            }
        }
        const double sum = std::accumulate(histogram.counts.begin(), histogram.counts.end(), 0.0);
        for (const std::size_t column : {0U, 1U}) {
            const auto sums = marginalOf(histogram, column);
            ASSERT_EQ(sums.size(), histogram.bins(column));
            ASSERT_NEAR(std::accumulate(sums.begin(), sums.end(), 0.0), sum,
                        1e-9 * (1.0 + std::abs(most) * 81));
        }
    }
}

TEST(HistogramView, ZoomsAboutThePlaceUnderTheMouse) {
    HistogramView view;
    view.fit({{"y", "m"}, {"x", "m"}, {"px", "eV/c"}});
    EXPECT_EQ(view.columns[0], "x");
    EXPECT_EQ(view.columns[1], "px");
    EXPECT_EQ(view.query().axes(0).range_size(), 0);
    Interval shown{-4.0, 4.0};
    for (int i = 0; i < 2000; ++i) {
        view.zoom(0, shown, 1.0, 0.85);
        ASSERT_LT(view.ranges[0]->low, 1.0);
        ASSERT_GT(view.ranges[0]->high, 1.0);
        shown = *view.ranges[0];
    }
    EXPECT_GT(shown.high - shown.low, 1e-10);
    EXPECT_EQ(view.query().axes(0).range(1), shown.high);
    view.setColumn(0, "y");
    EXPECT_FALSE(view.ranges[0].has_value());
}

TEST(PictureTool, ALassoIsTheHandsWayAndAClickIsNone) {
    PictureTool tool;
    PictureTool::Mouse mouse{{0.5, 0.5}, {0.001, 0.002}, true, true};
    EXPECT_FALSE(tool.takes(mouse));
    tool.toggle(PictureTool::Kind::lasso);
    EXPECT_TRUE(tool.takes(mouse));
    tool.move(mouse);
    mouse.pressed = false;
    mouse.held = false;
    EXPECT_TRUE(tool.move(mouse).lasso.empty());
    mouse.pressed = mouse.held = true;
    tool.move(mouse);
    mouse.pressed = false;
    std::vector<glm::dvec2> way{mouse.at};
    for (const glm::dvec2 next : {glm::dvec2(0.6, 0.5), glm::dvec2(0.6, 0.501), glm::dvec2(0.6, 0.7)}) {
        mouse.at = next;
        if (next.y != 0.501) way.push_back(next);  // half a pixel away
        EXPECT_TRUE(tool.move(mouse).lasso.empty());
    }
    mouse.held = false;
    EXPECT_EQ(tool.move(mouse).lasso, way);
    EXPECT_FALSE(tool.drawing());
}

TEST(PictureTool, PicksByItsKeyOrItsTool) {
    PictureTool tool;
    PictureTool::Mouse mouse{{0.25, 0.75}, {0.001, 0.001}, true, true, true};
    EXPECT_EQ(tool.move(mouse).pick, mouse.at);
    mouse.pressed = false;
    EXPECT_FALSE(tool.move(mouse).pick.has_value());
    tool.toggle(PictureTool::Kind::pick);
    mouse.picks = false;
    mouse.pressed = true;
    EXPECT_EQ(tool.move(mouse).pick, mouse.at);
    tool.toggle(PictureTool::Kind::pick);
    EXPECT_EQ(tool.kind(), PictureTool::Kind::none);
}

TEST(SeriesPlot, SpansWhatIsFinite) {
    const double none = std::numeric_limits<double>::quiet_NaN();
    const std::vector<double> values{none, 2.0, -3.0}, equal{5.0, 5.0};
    const auto extent = extentOf(values, {});
    EXPECT_LT(extent.low, -3.0);
    EXPECT_GT(extent.high, 2.0);
    EXPECT_LT(extentOf(equal, {}).low, extentOf(equal, {}).high);
    EXPECT_EQ(extentOf(std::vector<double>{none}, {}), Interval());
}

TEST(StatisticRows, AreTheStepsThenTheSelections) {
    StepStatistics whole, selected;
    whole.names = {"n_particle", "sigma_x", "cov_x__px"};
    whole.values = {1000.0, 1.5e-3, 2.0};
    selected.names = {"sigma_x", "n_particle"};
    selected.values = {std::numeric_limits<double>::quiet_NaN(), 0.0};
    const auto units = columnUnits({});
    auto rows = statisticRows(whole, selected, units, true);
    ASSERT_EQ(rows.size(), 3U);
    EXPECT_EQ(rows[0].whole, "1000");
    EXPECT_EQ(rows[0].selected, "0");
    EXPECT_EQ(rows[1].whole, "1.5000 mm");
    EXPECT_EQ(rows[1].selected, "-");
    EXPECT_EQ(rows[2].selected, "");
    EXPECT_EQ(statisticRows(whole, {}, units, false).size(), 2U);
    EXPECT_TRUE(statisticRows({}, {}, units, true).empty());
}

TEST(StatisticRows, ASeriesIsThatOfEveryStepOrNone) {
    proto::ParticlesManifest manifest;
    manifest.add_statistic_names("sigma_x");
    for (const double value : {1.0, 2.0}) manifest.add_steps()->add_statistics(value);
    EXPECT_EQ(seriesOf(manifest, "sigma_x"), (std::vector<double>{1.0, 2.0}));
    EXPECT_TRUE(seriesOf(manifest, "sigma_y").empty());
    manifest.add_steps();  // says less than it should
    EXPECT_TRUE(seriesOf(manifest, "sigma_x").empty());
}

}  // namespace
}  // namespace mote::client
