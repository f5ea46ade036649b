// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/stipple/thinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "preprocess/stipple/stipple_job.h"
#include "server/render/layers/stipple/replay.h"
#include "tests/support/plane_measures.h"
#include "tests/unit/stipple/test_progress.h"

namespace mote::prep {
namespace {

using test::measurePlane;
using test::PlaneMeasures;

storage::StippleHierarchy hierarchyOf(std::uint32_t points, std::uint64_t seed,
                                      const ThinningOptions& options = {}) {
    test::TestProgress progress;
    const auto start = evenPoints(points, seed, 0.5, progress);
    auto made = thinPlane(*start, options, 0.5, progress);
    EXPECT_TRUE(made.ok());
    return *std::move(made);
}

/// The points that replay draws where this share is wanted everywhere.
std::vector<glm::dvec2> drawn(const render::StippleReplay& replay, double share) {
    std::vector<glm::dvec2> points;
    for (const auto& placed :
         replay.place(replay.select(std::vector<float>(replay.size(), static_cast<float>(share))))) {
        points.emplace_back(placed.position.x, placed.position.y);
    }
    return points;
}

/// The bars of docs/STIPPLES.md.
bool meetsBars(const PlaneMeasures& m) {
    return m.rho >= 0.65 && m.nearest >= 0.86 && m.energy <= 1.05 && m.areaCv <= 0.085 &&
           m.lowEnergy <= 0.013;
}

void printTo(const PlaneMeasures& m, std::ostream& out) {
    out << "rho " << m.rho << " NN " << m.nearest << " E " << m.energy << " areaCV " << m.areaCv << " lowE "
        << m.lowEnergy;
}

TEST(Thinning, EveryLevelIsAsEvenAsItMustBe) {
    constexpr std::uint32_t points = 2500;
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        const render::StippleReplay replay(hierarchyOf(points, seed));
        for (const double level : {1.0, 0.95, 0.8, 0.65, 0.5, 0.35, 0.2, 0.1}) {
            const auto dots = drawn(replay, level);
            EXPECT_EQ(dots.size(), static_cast<std::size_t>(std::lround(level * points)));
            const auto measures = measurePlane(dots);
            EXPECT_TRUE(meetsBars(measures))
                << "seed " << seed << " level " << level << " " << (printTo(measures, std::cerr), "");
        }
    }
}

// Its least distance alone is no worse: nobody comes closer when others go.
TEST(Thinning, AStaticHierarchyIsNotEven) {
    const render::StippleReplay replay(hierarchyOf(2500, 1, {0, 1.0}));
    for (const double level : {0.8, 0.5, 0.2}) {
        const auto measures = measurePlane(drawn(replay, level));
        EXPECT_LT(measures.nearest, 0.86);
        EXPECT_GT(measures.energy, 1.05);
        EXPECT_GT(measures.areaCv, 0.085);
        EXPECT_GT(measures.lowEnergy, 0.013);
    }
}

/// Where a point lies once the first `removed` of the order are gone.
glm::dvec2 positionAfter(const storage::StippleHierarchy& h, std::uint32_t point, std::uint32_t removed) {
    auto at = h.positions[point];
    for (auto m = h.movesBegin[point]; m < h.movesBegin[point + 1]; ++m) {
        if (h.removal[h.moveNeighbour[m]] < removed) at = h.movePosition[m];
    }
    return {at.x, at.y};
}

TEST(Thinning, RemovesTheSmallestCellAndKnowsTheLargest) {
    // The whole story of a hierarchy again, with cells that are found by clipping.
    constexpr std::uint32_t points = 150;
    const auto h = hierarchyOf(points, 9);
    ASSERT_TRUE(storage::checkHierarchy(h).ok());
    std::vector<std::uint32_t> order(points);
    for (std::uint32_t i = 0; i < points; ++i) order[h.removal[i]] = i;
    std::vector<double> largest(points, 0.0);
    for (std::uint32_t removed = 0; removed < points; ++removed) {
        std::vector<glm::dvec2> positions;
        for (auto i = removed; i < points; ++i) positions.push_back(positionAfter(h, order[i], removed));
        const auto cells = test::voronoiCells(positions);
        double smallest = 1.0;
        for (auto i = removed; i < points; ++i) {
            const double area = cells[i - removed].area;
            largest[order[i]] = std::max(largest[order[i]], area);
            smallest = std::min(smallest, area);
        }
        // Positions are rounded to floats, 6e-8, and a cell's area changes with each of its corners by about
        // its diameter, at most 1.5, times that; some ten of them.
        EXPECT_NEAR(cells[0].area, smallest, 1e-6) << removed;
    }
    for (std::uint32_t i = 0; i < points; ++i) EXPECT_NEAR(h.deathArea[i], largest[i], 1e-6);
}

TEST(Thinning, MovesAreShortAndFew) {
    constexpr std::uint32_t points = 2500;
    const auto h = hierarchyOf(points, 4);
    // Euler: six neighbours and twelve in the second ring of the mean point; fewer at the end, when rings
    // meet around the square.
    EXPECT_LT(h.moveNeighbour.size(), std::size_t{18} * points);
    EXPECT_GT(h.moveNeighbour.size(), std::size_t{15} * points);
    for (std::uint32_t i = 0; i < points; ++i) {
        auto last = h.positions[i];
        for (auto m = h.movesBegin[i]; m < h.movesBegin[i + 1]; ++m) {
            const double left = points - h.removal[h.moveNeighbour[m]];
            const glm::vec3 step = h.movePosition[m] - last;
            last = h.movePosition[m];
            // The bar, in mean distances of the points that are left.
            EXPECT_TRUE(left < 30 || std::hypot(step.x, step.y) * std::sqrt(left) < 0.4) << left << " left";
        }
    }
}

TEST(Thinning, ReplayTakesFewBytes) {
    const auto h = hierarchyOf(2500, 4);
    // The bar: 120 bytes a point, what the dissertation needed.
    EXPECT_LT(render::StippleReplay(h).bytes(), std::size_t{120} * 2500);
}

TEST(Thinning, OneTwoAndThreePoints) {
    for (std::uint32_t points = 1; points <= 12; ++points) {
        const auto h = hierarchyOf(points, 1);
        ASSERT_EQ(h.size(), points);
        EXPECT_TRUE(storage::checkHierarchy(h).ok());
        // Who is left last has the whole square.
        EXPECT_NEAR(*std::max_element(h.deathArea.begin(), h.deathArea.end()), 1.0, 1e-6);
    }
}

TEST(Thinning, OneRingMovesTheNeighboursOnly) {
    const auto h = hierarchyOf(600, 2, {1, 1.0});
    EXPECT_LT(h.moveNeighbour.size(), 6U * 600U);
    EXPECT_GT(h.moveNeighbour.size(), 5U * 600U);
}

TEST(Thinning, CanBeCancelled) {
    test::TestProgress progress;
    const auto start = stratifiedPoints(3000, 1);
    progress.cancelAt(0.5);
    const auto made = thinPlane(start, {}, 0.0, progress);
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().code, ErrorCode::cancelled);
    EXPECT_EQ(evenPoints(100, 1, 0.5, progress).error().code, ErrorCode::cancelled);
}

TEST(PlaneStart, StratifiedPointsAreOneInEachBox) {
    for (const std::uint32_t points : {1U, 2U, 3U, 7U, 100U, 1001U}) {
        const auto made = stratifiedPoints(points, 3);
        ASSERT_EQ(made.size(), points);
        for (const auto& point : made) {
            EXPECT_TRUE(point.x > 0.0 && point.x < 1.0 && point.y > 0.0 && point.y < 1.0);
        }
    }
    EXPECT_EQ(stratifiedPoints(100, 3), stratifiedPoints(100, 3));
    EXPECT_NE(stratifiedPoints(100, 3), stratifiedPoints(100, 4));
}

TEST(PlaneStart, RelaxingOnceGoesToTheCentroids) {
    const auto points = stratifiedPoints(500, 8);
    const auto cells = test::voronoiCells(points);
    const auto relaxed = relaxOnce(points, 1.5);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto expected = points[i] + 1.5 * cells[i].centroid;
        // The grid of 2^-40, and ten roundings of numbers of order 1.
        EXPECT_NEAR(relaxed[i].x, expected.x, 1e-10);
        EXPECT_NEAR(relaxed[i].y, expected.y, 1e-10);
    }
}

}  // namespace
}  // namespace mote::prep
