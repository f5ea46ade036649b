// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/stipple/replay.h"

#include <gmock/gmock.h>
#include <tbb/task_arena.h>

#include <limits>
#include <numeric>
#include <random>

#include "tests/unit/stipple/small_hierarchy.h"

namespace mote::render {
namespace {

using test::smallHierarchy;

TEST(StippleReplay, AUniformShareDrawsThatManyPointsInTheOrderOfRemoval) {
    const StippleReplay replay(smallHierarchy());
    const auto count = [&](float share) {
        const auto drawn = replay.select(std::vector<float>(5, share));
        // Who is drawn is removed after everybody who is not.
        for (std::size_t i = 0; i < 5; ++i) {
            for (std::size_t j = 0; j < 5; ++j) {
                EXPECT_TRUE(drawn[i] == 0 || drawn[j] != 0 || replay.rank(i) > replay.rank(j));
            }
        }
        return std::accumulate(drawn.begin(), drawn.end(), 0);
    };
    for (int n = 0; n <= 5; ++n) EXPECT_EQ(count(static_cast<float>(n) / 5.0F), n);
    EXPECT_EQ(count(0.09F), 0);  // rounds to none and to one
    EXPECT_EQ(count(0.11F), 1);
    EXPECT_EQ(count(7.0F), 5);
    EXPECT_EQ(count(-1.0F), 0);
    EXPECT_EQ(count(std::numeric_limits<float>::quiet_NaN()), 0);
    EXPECT_EQ(count(std::numeric_limits<float>::infinity()), 5);
}

TEST(StippleReplay, AMoveIsMadeOnlyWhenAllBeforeItAre) {
    const StippleReplay replay(smallHierarchy());
    const auto at = [&](std::vector<std::uint8_t> drawn, std::size_t point) {
        return replay.placed(point, drawn);
    };
    EXPECT_EQ(at({1, 1, 1, 1, 1}, 1), glm::vec3(0.3F, 0, 0));
    EXPECT_EQ(at({1, 1, 0, 1, 1}, 1), glm::vec3(0.31F, 0, 0));
    EXPECT_EQ(at({0, 1, 0, 1, 1}, 1), glm::vec3(0.31F, 0.5F, 0));
    EXPECT_EQ(at({0, 1, 0, 1, 0}, 1), glm::vec3(0.31F, 0.6F, 0));
    // Out of the order of removal: 4 is gone and 0 is not, so the move for 4 waits.
    EXPECT_EQ(at({1, 1, 0, 1, 0}, 1), glm::vec3(0.31F, 0, 0));
    EXPECT_EQ(at({0, 1, 1, 1, 0}, 1), glm::vec3(0.3F, 0, 0));
    EXPECT_EQ(at({0, 0, 0, 1, 0}, 3), glm::vec3(0.6F, 0, 0));
    EXPECT_EQ(at({0, 0, 0, 0, 1}, 4), replay.position(4));
}

TEST(StippleReplay, PlacesTheDrawnInTheirOrder) {
    const StippleReplay replay(smallHierarchy());
    const std::vector<std::uint8_t> drawn{0, 1, 0, 1, 0};
    const auto points = replay.place(drawn);
    ASSERT_EQ(points.size(), 2U);
    EXPECT_EQ(points[0].point, 1U);
    EXPECT_EQ(points[0].position, glm::vec3(0.31F, 0.6F, 0));
    EXPECT_EQ(points[1].point, 3U);
    EXPECT_EQ(points[1].position, glm::vec3(0.69F, 0, 0));
    EXPECT_TRUE(replay.place(std::vector<std::uint8_t>(5, 0)).empty());
}

/// P points without geometry; each moves when each of the eight before it in rank goes.
storage::StippleHierarchy chain(std::uint32_t points) {
    storage::StippleHierarchy h;
    h.movesBegin.push_back(0);
    for (std::uint32_t i = 0; i < points; ++i) {
        h.positions.push_back({static_cast<float>(i), 0, 0});
        h.rank.push_back(i);
        for (std::uint32_t n = i < 8 ? 0 : i - 8; n < i; ++n) {
            h.moveNeighbour.push_back(n);
            h.movePosition.push_back({static_cast<float>(i), static_cast<float>(n), 1});
        }
        h.movesBegin.push_back(h.moveNeighbour.size());
    }
    h.normals.assign(points, {0, 0, 1});
    h.deathArea.assign(points, 1.0F);
    h.locked.assign(points, 0);
    return h;
}

TEST(StippleReplay, ThreadsChangeNothing) {
    constexpr std::uint32_t points = 50000;
    const StippleReplay replay(chain(points));
    std::mt19937 random(1);
    std::vector<float> shares(points);
    for (auto& share : shares) share = static_cast<float>(random()) / 4294967296.0F;
    const auto run = [&](int threads) {
        tbb::task_arena arena(threads);
        return arena.execute([&] { return replay.place(replay.select(shares)); });
    };
    const auto one = run(1);
    const auto four = run(4);
    ASSERT_EQ(one.size(), four.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
        ASSERT_EQ(one[i].point, four[i].point);
        ASSERT_EQ(one[i].position, four[i].position);
    }
}

}  // namespace
}  // namespace mote::render
