// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/numbers_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <set>

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

}  // namespace
}  // namespace mote::client
