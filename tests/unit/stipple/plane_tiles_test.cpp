// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/plane_tiles.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <tuple>

#include "server/render/layers/stipple/replay.h"

namespace mote::render {
namespace {

using storage::StippleHierarchy;

/// Random points that move at random when one of their nearest is removed: what matters here is who moves for
/// whom and across which seam, not how evenly.
StippleHierarchy randomHierarchy(std::uint32_t points) {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    StippleHierarchy h;
    for (std::uint32_t i = 0; i < points; ++i) h.positions.push_back({unit(random), unit(random), 0.0F});
    h.normals.assign(points, {0, 0, 1});
    h.removal.resize(points);
    std::iota(h.removal.begin(), h.removal.end(), 0U);
    std::shuffle(h.removal.begin(), h.removal.end(), random);
    h.deathArea.assign(points, 1.0F);
    h.locked.assign(points, 0);
    h.movesBegin = {0};
    for (std::uint32_t i = 0; i < points; ++i) {
        std::vector<std::pair<std::uint32_t, std::uint32_t>> earlier;  // removal, point
        for (std::uint32_t j = 0; j < points; ++j) {
            auto apart = h.positions[i] - h.positions[j];
            apart -= glm::vec3(std::round(apart.x), std::round(apart.y), 0.0F);
            if (std::hypot(apart.x, apart.y) < 0.12F && h.removal[j] < h.removal[i])
                earlier.emplace_back(h.removal[j], j);
        }
        std::sort(earlier.begin(), earlier.end());
        for (const auto& [removal, point] : earlier) {
            h.moveNeighbour.push_back(point);
            h.movePosition.push_back(h.positions[i] +
                                     0.05F * glm::vec3(unit(random) - 0.5F, unit(random) - 0.5F, 0));
        }
        h.movesBegin.push_back(h.moveNeighbour.size());
    }
    return h;
}

PixelMap even(std::uint32_t width, std::uint32_t height, double density) {
    return {width, height, std::vector<float>(std::size_t{width} * height, static_cast<float>(density))};
}

class PlaneTilesTest : public ::testing::Test {
  protected:
    StippleHierarchy hierarchy_ = randomHierarchy(400);
    PlaneTiles tiles_{std::make_shared<const StippleHierarchy>(hierarchy_)};
};

/// Every tile of an even density is the replay of the hierarchy itself.
TEST_F(PlaneTilesTest, evenDensityIsTheReplay) {
    const StippleReplay replay(hierarchy_);
    constexpr double full = 400.0 / (100.0 * 100.0);  // tiles of 100 pixels
    for (const double share : {0.1, 0.35, 0.8, 1.0}) {
        const auto drawn = replay.select(std::vector<float>(400, static_cast<float>(share)));
        const auto wanted = even(300, 250, share * full);
        auto selection = tiles_.select(wanted, {full});
        tiles_.place(selection);
        std::size_t inMiddle = 0;
        for (const auto& dot : selection.dots) {
            EXPECT_EQ(drawn[dot.point], 1) << share;
            if (dot.column != 1 || dot.row != 1) continue;
            ++inMiddle;
            auto place = hierarchy_.positions[dot.point];
            for (auto m = hierarchy_.movesBegin[dot.point]; m < hierarchy_.movesBegin[dot.point + 1]; ++m) {
                if (drawn[hierarchy_.moveNeighbour[m]] != 0) break;
                place = hierarchy_.movePosition[m];
            }
            EXPECT_NEAR(dot.place.x, 100.0 * (1.0 + place.x), 1e-3);
            EXPECT_NEAR(dot.place.y, 100.0 * (1.0 + place.y), 1e-3);
        }
        EXPECT_EQ(inMiddle, static_cast<std::size_t>(std::accumulate(drawn.begin(), drawn.end(), 0)));
    }
}

/// Where the density varies, each dot of each tile obeys its neighbours' nearest images.
TEST_F(PlaneTilesTest, movesAcrossSeams) {
    constexpr double full = 400.0 / (100.0 * 100.0);
    std::vector<float> density(std::size_t{300} * 300);
    for (std::size_t i = 0; i < density.size(); ++i) {
        density[i] = static_cast<float>(full * (0.5 + 0.5 * std::sin(0.07 * static_cast<double>(i % 300)) *
                                                          std::cos(0.05 * static_cast<double>(i / 300))));
    }
    auto selection = tiles_.select({300, 300, density}, {full});
    tiles_.place(selection);
    std::map<std::tuple<int, int, std::uint32_t>, bool> drawn;
    for (const auto& dot : selection.dots) drawn[{dot.column, dot.row, dot.point}] = true;
    ASSERT_GT(selection.dots.size(), 1000u);
    std::size_t moved = 0;
    for (const auto& dot : selection.dots) {
        glm::vec3 expected = hierarchy_.positions[dot.point];
        for (auto m = hierarchy_.movesBegin[dot.point]; m < hierarchy_.movesBegin[dot.point + 1]; ++m) {
            const auto neighbour = hierarchy_.moveNeighbour[m];
            // Of the neighbour's nine images the nearest.
            std::tuple<float, int, int> nearest{1e9F, 0, 0};
            for (int dx = -1; dx <= 1; ++dx) {
                for (int dy = -1; dy <= 1; ++dy) {
                    const auto apart = hierarchy_.positions[neighbour] +
                                       glm::vec3(static_cast<float>(dx), static_cast<float>(dy), 0.0F) -
                                       hierarchy_.positions[dot.point];
                    nearest = std::min(nearest, {std::hypot(apart.x, apart.y), dx, dy});
                }
            }
            if (drawn.contains(
                    {dot.column + std::get<1>(nearest), dot.row + std::get<2>(nearest), neighbour}))
                break;
            expected = hierarchy_.movePosition[m];
            ++moved;
        }
        EXPECT_NEAR(dot.place.x, 100.0F * (static_cast<float>(dot.column) + expected.x), 1e-3);
        EXPECT_NEAR(dot.place.y, 100.0F * (static_cast<float>(dot.row) + expected.y), 1e-3);
    }
    EXPECT_GT(moved, 1000u);
}

TEST_F(PlaneTilesTest, nothingIsWantedNothingIsDrawn) {
    EXPECT_TRUE(tiles_.select(even(50, 50, 0.0), {0.04}).dots.empty());
}

/// One point, a tile smaller than a pixel, and a picture of one pixel.
TEST_F(PlaneTilesTest, extremes) {
    StippleHierarchy one = randomHierarchy(1);
    const PlaneTiles single(std::make_shared<const StippleHierarchy>(one));
    auto selection = single.select(even(30, 20, 0.01), {0.01});
    single.place(selection);
    const auto inside = std::count_if(selection.dots.begin(), selection.dots.end(), [](const TileDot& dot) {
        return dot.place.x >= 0 && dot.place.x < 30 && dot.place.y >= 0 && dot.place.y < 20;
    });
    EXPECT_EQ(inside, 6);
    EXPECT_FALSE(single.select(even(1, 1, 4.0), {4.0}).dots.empty());
}

TEST_F(PlaneTilesTest, wakesTheNearestThatSleeps) {
    constexpr double full = 400.0 / (100.0 * 100.0);
    auto selection = tiles_.select(even(200, 200, 0.5 * full), {full});
    const auto before = selection.drawn;
    const auto woken = tiles_.wake(selection, {123.0, 45.0});
    ASSERT_TRUE(woken.has_value());
    const auto changed = std::inner_product(before.begin(), before.end(), selection.drawn.begin(), 0,
                                            std::plus<>(), std::not_equal_to<>());
    EXPECT_EQ(changed, 1);
    const auto first = hierarchy_.positions[woken->point];
    const auto gap = [](double x, double y) { return std::hypot(x - 123.0, y - 45.0); };
    const double found = gap(100.0 * (woken->column + first.x), 100.0 * (woken->row + first.y));
    for (std::uint32_t i = 0; i < 400; ++i) {
        for (int column = 0; column < 2; ++column) {
            const auto flag = selection.tiling.index(column, 0) * 400 + i;
            const auto& place = hierarchy_.positions[i];
            EXPECT_TRUE(before[flag] != 0 || gap(100.0 * (column + place.x), 100.0 * place.y) >= found);
        }
    }
    tiles_.letSleep(selection, *woken);
    EXPECT_EQ(selection.drawn, before);
}

TEST_F(PlaneTilesTest, sameOnAnyThreads) {
    constexpr double full = 400.0 / (40.0 * 40.0);
    const auto wanted = even(300, 300, 0.4 * full);
    auto all = tiles_.select(wanted, {full});
    tiles_.place(all);
    tbb::task_arena arena(1);
    arena.execute([&] {
        auto alone = tiles_.select(wanted, {full});
        tiles_.place(alone);
        ASSERT_EQ(alone.dots.size(), all.dots.size());
        for (std::size_t i = 0; i < all.dots.size(); ++i) EXPECT_EQ(alone.dots[i].place, all.dots[i].place);
    });
}

}  // namespace
}  // namespace mote::render
