// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/replay.h"

#include <gmock/gmock.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
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
                EXPECT_TRUE(drawn[i] == 0 || drawn[j] != 0 || replay.removal(i) > replay.removal(j));
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

/// Positions are kept to within this in every hierarchy of these tests: see PackedMoves::error.
constexpr float tolerance = 0.01F;

void expectAt(const glm::vec3& is, const glm::vec3& should) {
    for (int d = 0; d < 3; ++d) EXPECT_NEAR(is[d], should[d], tolerance) << d;
}

TEST(StippleReplay, AMoveIsMadeOnlyWhenAllBeforeItAre) {
    const StippleReplay replay(smallHierarchy());
    for (std::uint32_t left = 1; left <= 5; ++left) EXPECT_LT(replay.moves().error(left), tolerance);
    const auto at = [&](std::vector<std::uint8_t> drawn, std::size_t point) {
        return replay.placed(point, drawn);
    };
    EXPECT_EQ(at({1, 1, 1, 1, 1}, 1), replay.position(1));
    expectAt(at({1, 1, 0, 1, 1}, 1), {0.4F, 0, 0});
    expectAt(at({0, 1, 0, 1, 1}, 1), {0.4F, 0.1F, 0});
    expectAt(at({0, 1, 0, 1, 0}, 1), {0.5F, 0.1F, 0});
    // Out of the order of removal: 4 is gone and 0 is not, so the move for 4 waits.
    expectAt(at({1, 1, 0, 1, 0}, 1), {0.4F, 0, 0});
    EXPECT_EQ(at({0, 1, 1, 1, 0}, 1), replay.position(1));
    expectAt(at({0, 0, 0, 1, 0}, 3), {0.6F, 0.1F, 0});
    EXPECT_EQ(at({0, 0, 0, 0, 1}, 4), replay.position(4));
}

TEST(StippleReplay, PlacesTheDrawnInTheirOrder) {
    const StippleReplay replay(smallHierarchy());
    const std::vector<std::uint8_t> drawn{0, 1, 0, 1, 0};
    const auto points = replay.place(drawn);
    ASSERT_EQ(points.size(), 2U);
    EXPECT_EQ(points[0].point, 1U);
    expectAt(points[0].position, {0.5F, 0.1F, 0});
    EXPECT_EQ(points[1].point, 3U);
    expectAt(points[1].position, {0.6F, 0, 0});
    EXPECT_TRUE(replay.place(std::vector<std::uint8_t>(5, 0)).empty());
}

/// A hierarchy in space of random moves about as long as the distance of the points that are left, a few of
/// them a hundred times as long, over more points than lie in a block.
storage::StippleHierarchy wild() {
    constexpr std::uint32_t points = 9000;
    std::mt19937 random(5);
    std::normal_distribution<float> normal;
    const auto vector = [&](float length) {
        return length * glm::vec3(normal(random), normal(random), normal(random));
    };
    storage::StippleHierarchy h;
    h.removal.resize(points);
    std::iota(h.removal.begin(), h.removal.end(), 0U);
    std::shuffle(h.removal.begin(), h.removal.end(), random);
    std::vector<std::uint32_t> order(points);
    for (std::uint32_t i = 0; i < points; ++i) order[h.removal[i]] = i;
    h.movesBegin.push_back(0);
    for (std::uint32_t i = 0; i < points; ++i) {
        auto at = h.positions.emplace_back(vector(1.0F));
        h.normals.push_back(glm::normalize(vector(1.0F)));
        for (std::uint32_t removal = random() % 4000; removal < h.removal[i];
             removal += 1 + random() % 4000) {
            const float distance = 1.0F / std::sqrt(static_cast<float>(points - removal));
            at += vector(random() % 50 == 0 ? 100.0F * distance : distance);
            h.moveNeighbour.push_back(order[removal]);
            h.movePosition.push_back(at);
        }
        h.movesBegin.push_back(h.moveNeighbour.size());
    }
    h.deathArea.assign(points, 1.0F);
    h.locked.assign(points, 0);
    return h;
}

TEST(PackedMoves, KeepNeighboursExactlyAndPlacesClosely) {
    const auto h = wild();
    ASSERT_TRUE(storage::checkHierarchy(h).ok());
    const PackedMoves packed(h);
    for (std::size_t i = 0; i < h.size(); ++i) {
        auto walk = packed.walk(i, h.positions[i]);
        for (auto m = h.movesBegin[i]; m < h.movesBegin[i + 1]; ++m) {
            const auto removal = walk.next();
            ASSERT_TRUE(removal);
            ASSERT_EQ(*removal, h.removal[h.moveNeighbour[m]]);
            walk.make();
            // Sums of floats of order 10 besides.
            const float error = packed.error(static_cast<std::uint32_t>(h.size()) - *removal) + 1e-5F;
            for (int d = 0; d < 3; ++d) ASSERT_NEAR(walk.position()[d], h.movePosition[m][d], error);
        }
        ASSERT_FALSE(walk.next());
    }
}

/// P points without geometry; each moves when each of the eight before it in removal goes.
storage::StippleHierarchy chain(std::uint32_t points) {
    storage::StippleHierarchy h;
    h.movesBegin.push_back(0);
    for (std::uint32_t i = 0; i < points; ++i) {
        h.positions.push_back({static_cast<float>(i), 0, 0});
        h.removal.push_back(i);
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
