// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/played_series.h"

#include <gmock/gmock.h>

namespace mote::server {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::vector<std::uint32_t> after(const std::vector<std::uint32_t>& asked, std::uint32_t steps = 100,
                                 std::size_t most = 3) {
    PlayOrder order(steps);
    for (const auto step : asked) order.asked(step);
    return order.next(most);
}

TEST(PlayOrder, NothingIsExpectedOfASingleStepOrOfJumps) {
    EXPECT_THAT(after({}), IsEmpty());
    EXPECT_THAT(after({5}), IsEmpty());
    EXPECT_THAT(after({5, 5, 5}), IsEmpty());
    EXPECT_THAT(after({5, 30}), IsEmpty());
    EXPECT_THAT(after({5, 30, 10}), IsEmpty());
    EXPECT_THAT(after({0}, 1), IsEmpty());
}

TEST(PlayOrder, TheNeighbourIsTheBeginningOfAnOrder) {
    EXPECT_THAT(after({5, 6}), ElementsAre(7, 8, 9));
    EXPECT_THAT(after({6, 5}), ElementsAre(4, 3, 2));
    EXPECT_THAT(after({5, 5, 6, 6}), ElementsAre(7, 8, 9));
}

TEST(PlayOrder, EvenStridesGoOn) {
    EXPECT_THAT(after({0, 10, 20}), ElementsAre(30, 40, 50));
    EXPECT_THAT(after({50, 45, 40}), ElementsAre(35, 30, 25));
}

TEST(PlayOrder, AStepThatWasLeftOutDoesNotEndAnOrder) {
    EXPECT_THAT(after({1, 2, 4}), ElementsAre(5, 6, 7));
    EXPECT_THAT(after({1, 3, 4}), ElementsAre(5, 6, 7));
}

TEST(PlayOrder, ItGoesRoundAtTheEnd) {
    EXPECT_THAT(after({97, 98, 99}), ElementsAre(0, 1, 2));
    EXPECT_THAT(after({98, 99, 0}), ElementsAre(1, 2, 3));
    EXPECT_THAT(after({1, 0}), ElementsAre(99, 98, 97));
}

TEST(PlayOrder, AShortSeriesIsExpectedOnce) {
    EXPECT_THAT(after({0, 1}, 3, 10), ElementsAre(2, 0));
    EXPECT_THAT(after({0, 1}, 2, 10), ElementsAre(0));
    EXPECT_THAT(after({0, 5, 10}, 20, 10), ElementsAre(15, 0, 5));
}

TEST(PlayOrder, TheGreatestNumberOfStepsCountsRight) {
    EXPECT_THAT(after({4294967293U, 4294967294U}, 4294967295U), ElementsAre(0, 1, 2));
}

}  // namespace
}  // namespace mote::server
