// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/step_volume.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <random>
#include <utility>

#include "protocol/scene/particles_style.h"
#include "server/render/plan/matter/cell_grid.h"
#include "server/render/plan/matter/leaves_by_cell.h"
#include "server/render/plan/point_selection.h"
#include "tests/support/beams.h"
#include "tests/support/memory_step.h"
#include "tests/support/volume_matter.h"

namespace mote::render {
namespace {

using test::MemoryStep;
using test::WeightedPoint;

TransferFunction shown(std::vector<Curve::Knot> knots) {
    return ParticlesStyle::transferOf(Curve::create(std::move(knots)).value(), ColorMap::standard());
}

/// Where a curve shows nothing.
Curve allPoints() {
    return Curve::constant(1.0);
}

/// Particles on a plane that is a little thicker than nothing, in any direction.
std::vector<WeightedPoint> sheet(std::size_t count, double thickness, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> even(0.1, 0.9);
    std::normal_distribution<double> off(0.0, thickness);
    std::vector<WeightedPoint> points;
    for (std::size_t i = 0; i < count; ++i) {
        const double x = even(random), y = even(random);
        points.push_back({{x, y, 0.3 + 0.2 * x + 0.2 * y + off(random)}, 1.0});
    }
    return points;
}

std::vector<WeightedPoint> ball(std::size_t count, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> even(-1.0, 1.0);
    std::vector<WeightedPoint> points;
    while (points.size() < count) {
        const double x = even(random), y = even(random), z = even(random);
        if (x * x + y * y + z * z < 1.0)
            points.push_back({{0.5 + 0.3 * x, 0.5 + 0.3 * y, 0.5 + 0.3 * z}, 1.0});
    }
    return points;
}

/// Of all leaves: extinction times the part of it that is volume, times their part of the box.
double matterOfLeaves(const MemoryStep& step, const TransferFunction& transfer, const StepVolume& volume) {
    const auto leaves = step.leaves();
    double sum = 0.0;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const double t = step.logDensity().ofLeaf(leaves.density[i]);
        sum += volume.shareOf(i) * transfer.extinction(t) *
               std::ldexp(1.0, -3 * step.nodes().level[leaves.node[i]]);
    }
    return sum;
}

double meanShare(const MemoryStep& step, const StepVolume& volume) {
    const auto leaves = step.leaves();
    double sum = 0.0, points = 0.0;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        sum += leaves.pointCount[i] * volume.shareOf(i);
        points += leaves.pointCount[i];
    }
    return sum / points;
}

/// The same of the leaves whose cells lie within ball()'s surface by a corner's way of theirs and of the
/// volume's.
double meanShareInBall(const MemoryStep& step, const StepVolume& volume) {
    const auto leaves = step.leaves();
    double sum = 0.0, points = 0.0;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const CellAt at(step.nodes().level[leaves.node[i]], step.nodes().morton[leaves.node[i]]);
        const double edge = std::ldexp(1.0, -static_cast<int>(at.level));
        const double reach = std::sqrt(3.0) * (0.5 * edge + std::ldexp(1.0, -static_cast<int>(volume.level)));
        if (glm::length((glm::dvec3(at.place) + 0.5) * edge - 0.5) + reach > 0.3) continue;
        sum += leaves.pointCount[i] * volume.shareOf(i);
        points += leaves.pointCount[i];
    }
    EXPECT_GT(points, 100.0);
    return sum / points;
}

TEST(StepVolume, HoldsAllThatItsLeavesShowWhateverTheCurveAndTheCells) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        std::mt19937_64 random(seed);
        std::uniform_real_distribution<double> share(0.0, 1.0);
        const auto points = seed % 3 == 0 ? sheet(20000, 1e-3, seed)
                            : seed % 3 == 1
                                ? ball(20000, seed)
                                : test::beam({.core = 15000, .halo = 3000, .filaments = 2000, .seed = seed});
        const auto step = MemoryStep::make(
            points, {.leafCapacity = 32, .maxLevel = 10, .volumeLevel = static_cast<std::uint8_t>(seed % 7)});
        std::vector<Curve::Knot> knots;
        for (int i = 0; i <= 8; ++i) knots.push_back({i / 8.0, share(random) * (seed % 2 == 0 ? 1.0 : 0.1)});
        const auto transfer = shown(knots);
        const auto volume = stepVolume(*step, transfer, allPoints());
        ASSERT_FALSE(volume.empty());
        EXPECT_LE(volume.root.size(), std::size_t{1} << (3 * (seed % 7)));
        const double expected = matterOfLeaves(*step, transfer, volume);
        EXPECT_NEAR(test::matterOf(volume), expected, 0.05 * expected) << seed;
    }
}

TEST(StepVolume, AThinSheetStaysPointsAndABallIsAVolume) {
    const auto transfer = shown({{0.0, 0.1}, {1.0, 0.3}});
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        const auto thin = MemoryStep::make(sheet(100000, 1e-4, seed), {.leafCapacity = 32, .volumeLevel = 5});
        EXPECT_LT(meanShare(*thin, stepVolume(*thin, transfer, allPoints())), 0.1) << seed;
        const auto thick = MemoryStep::make(ball(100000, seed), {.leafCapacity = 32, .volumeLevel = 5});
        EXPECT_GT(meanShare(*thick, stepVolume(*thick, transfer, allPoints())), 0.95) << seed;
    }
}

/// Where leaves are larger than cells, or of many sizes, a sheet is no thicker for that.
TEST(StepVolume, ASheetIsThinHoweverItLiesAndHoweverLargeItsLeavesAre) {
    const auto transfer = shown({{0.0, 0.1}, {1.0, 0.3}});
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        std::mt19937_64 random(seed);
        std::uniform_real_distribution<double> slope(-0.6, 0.6);
        auto points = sheet(20000, 0.0, seed);
        const double alongX = slope(random), alongY = slope(random);
        for (auto& [place, weight] : points)
            place.z = 0.5 + alongX * (place.x - 0.5) + alongY * (place.y - 0.5);
        const auto level = static_cast<std::uint8_t>(4 + seed % 4);
        const auto thin = MemoryStep::make(points, {.leafCapacity = 64, .volumeLevel = level});
        EXPECT_LT(meanShare(*thin, stepVolume(*thin, transfer, allPoints())), 0.05) << seed;
        const auto thick = MemoryStep::make(ball(50000, seed), {.leafCapacity = 64, .volumeLevel = level});
        // Leaves at its edge are half filled, and points in part.
        const auto volume = stepVolume(*thick, transfer, allPoints());
        EXPECT_GT(meanShare(*thick, volume), 0.85) << seed;
        EXPECT_GT(meanShareInBall(*thick, volume), 0.95) << seed;
    }
}

/// A tilted core of some cells is a volume, and so are the leaves around it that are as large as cells: were
/// every other one of them points, these would lie before it in stripes.
TEST(StepVolume, WhatLiesAroundATiltedCoreIsAsThickAsTheCore) {
    constexpr std::uint8_t level = 5;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        const auto step =
            MemoryStep::make(sheet(400000, 0.9 / 32.0, seed), {.leafCapacity = 32, .volumeLevel = level});
        const auto volume = stepVolume(*step, shown({{0.0, 0.1}, {1.0, 0.3}}), allPoints());
        ASSERT_EQ(volume.level, level);
        const auto leaves = step->leaves();
        double sum = 0.0, points = 0.0;
        for (std::size_t i = 0; i < leaves.size(); ++i) {
            if (step->nodes().level[leaves.node[i]] != level || leaves.pointCount[i] < 16) continue;
            sum += leaves.pointCount[i] * volume.shareOf(i);
            points += leaves.pointCount[i];
        }
        EXPECT_GT(points, 1000.0);
        EXPECT_GT(sum / points, 0.8) << seed;
    }
}

/// How much of the particles is volume, on average: of those in leaves whose cell of the volume, or their own
/// if that is larger, lies on one side of a plane, with its centre from so far to so far before it, in cells.
double meanShareAt(const MemoryStep& step, const StepVolume& volume, const glm::dvec3& normal, double from,
                   double to) {
    const auto leaves = step.leaves();
    const auto nodes = step.nodes();
    double sum = 0.0, points = 0.0;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const CellAt at(nodes.level[leaves.node[i]], nodes.morton[leaves.node[i]]);
        const unsigned level = std::min(at.level, volume.level);
        const auto cell = glm::dvec3(at.place >> glm::uvec3(at.level - level)) + 0.5;
        const double before = glm::dot(normal, cell - std::ldexp(0.5, static_cast<int>(level)));
        if (before < from || before > to) continue;
        sum += leaves.pointCount[i] * volume.shareOf(i);
        points += leaves.pointCount[i];
    }
    EXPECT_GT(points, 100.0);
    return sum / points;
}

/// A cell most of which lies outside of what is dense is not volume all over, whether its leaves are as large
/// as it or smaller; cells that hardly differ from those within are.
TEST(StepVolume, AnEdgeIsPointsWhereMostOfACellIsEmpty) {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        std::mt19937_64 random(seed);
        std::uniform_real_distribution<double> even(0.0, 1.0);
        std::normal_distribution<double> any;
        const auto normal = glm::normalize(glm::dvec3(any(random), any(random), any(random)));
        std::vector<WeightedPoint> half;
        const std::size_t count = seed % 2 == 0 ? 20000 : 200000;  // 10 and 100 in a cell
        while (half.size() < count) {
            const glm::dvec3 place(even(random), even(random), even(random));
            if (glm::dot(normal, place - 0.5) < 0.0) half.push_back({place, 1.0});
        }
        const auto step = MemoryStep::make(half, {.leafCapacity = 32, .volumeLevel = 4});
        const auto volume = stepVolume(*step, shown({{0.0, 0.1}, {1.0, 0.3}}), allPoints());
        EXPECT_LT(meanShareAt(*step, volume, normal, 0.25, 2.0), 0.3) << seed;
        EXPECT_GT(meanShareAt(*step, volume, normal, -4.0, -1.0), 0.95) << seed;
        // Far from it, the points of a leaf lie to one side by chance alone.
        EXPECT_GT(meanShareAt(*step, volume, normal, -8.0, -2.0), 0.996) << seed;
    }
}

/// The density of a leaf tells how many lumps it holds, not how dense matter is there.
TEST(StepVolume, ALatticeOfLumpsStaysPointsAndAGasIsAVolume) {
    const auto transfer = shown({{0.0, 0.1}, {1.0, 0.3}});
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        std::mt19937_64 random(seed);
        std::uniform_real_distribution<double> anywhere(0.0, 1.0);
        const auto side = static_cast<double>(9 + 2 * seed);
        std::vector<WeightedPoint> gas(60000, {glm::dvec3(0.0), 1.0});
        for (auto& [place, weight] : gas) place = {anywhere(random), anywhere(random), anywhere(random)};
        auto lattice = gas;
        for (auto& [place, weight] : lattice) place = (glm::floor(place * side) + 0.5) / side + 1e-5 * place;
        const test::MemoryStepOptions options{.leafCapacity = 64, .volumeLevel = 5};
        const auto lumps = MemoryStep::make(lattice, options), even = MemoryStep::make(gas, options);
        EXPECT_LT(meanShare(*lumps, stepVolume(*lumps, transfer, allPoints())), 0.05) << seed;
        EXPECT_GT(meanShare(*even, stepVolume(*even, transfer, allPoints())), 0.95) << seed;
    }
}

/// Of the particles in leaves that the curve shows: how much is volume, on average.
double meanShareSeen(const MemoryStep& step, const TransferFunction& transfer,
                     const Curve& fraction = allPoints()) {
    const auto volume = stepVolume(step, transfer, fraction);
    const auto leaves = step.leaves();
    double sum = 0.0, points = 0.0;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        if (!(transfer.extinction(step.logDensity().ofLeaf(leaves.density[i])) > 0.0)) continue;
        sum += leaves.pointCount[i] * volume.shareOf(i);
        points += leaves.pointCount[i];
    }
    return sum / points;
}

/// The t that a share of the leaves reaches at most.
double quantile(const MemoryStep& step, double share) {
    const auto densities = step.leaves().density;  // ascending
    const auto at = static_cast<double>(densities.size()) * share;
    return step.logDensity().ofLeaf(densities[static_cast<std::size_t>(at)]);
}

/// Leaves of an even gas differ by chance: a curve that begins among them shows no volume, but cells here and
/// there. Where nothing else is shown, these are what was asked for.
TEST(StepVolume, WhatIsAloneAmongPointsIsPoints) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        const auto gas = MemoryStep::make(test::evenCloud(30000 + 5000 * seed, seed),
                                          {.leafCapacity = 32, .volumeLevel = 5});
        const double rare = quantile(*gas, 0.95);
        const auto few = shown({{rare, 0.0}, {rare, 0.2}});
        EXPECT_LT(meanShareSeen(*gas, few), 0.02) << seed;
        EXPECT_GT(meanShareSeen(*gas, few, Curve::constant(0.0)), 0.98) << seed;
        const double most = quantile(*gas, 0.05);
        EXPECT_GT(meanShareSeen(*gas, shown({{most, 0.0}, {most, 0.2}})), 0.9) << seed;
    }
}

TEST(StepVolume, ADenseBallAmongPointsIsAVolume) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        auto points = ball(50000, seed);
        for (const auto& point : test::evenCloud(10000, seed + 100)) points.push_back(point);
        const auto both = MemoryStep::make(points, {.leafCapacity = 32, .volumeLevel = 5});
        const auto transfer = shown({{0.5, 0.0}, {0.5, 0.2}});
        EXPECT_GT(meanShareSeen(*both, transfer), 0.93) << seed;  // but its edge
        EXPECT_GT(meanShareInBall(*both, stepVolume(*both, transfer, allPoints())), 0.95) << seed;
    }
}

TEST(StepVolume, WhatTheVolumeDoesNotHoldIsDrawnAsPoints) {
    const auto step = MemoryStep::make(sheet(50000, 3e-3, 9), {.leafCapacity = 32, .volumeLevel = 6});
    const auto transfer = shown({{0.0, 0.1}, {1.0, 0.3}});
    const auto volume = std::make_shared<const StepVolume>(stepVolume(*step, transfer, allPoints()));
    const auto none = Curve::constant(0.0);  // by their density none is a point
    const auto selection = selectPoints(*step, {.fraction = none, .volume = volume});
    double expected = 0.0;
    const auto leaves = step->leaves();
    for (std::size_t i = 0; i < leaves.size(); ++i)
        expected += leaves.pointCount[i] * (1.0 - volume->shareOf(i));
    // Each leaf rounds by less than a point, at random: four standard deviations.
    EXPECT_NEAR(static_cast<double>(selection.points), expected, 4.0 * std::sqrt(0.25 * leaves.size()));
    const auto needed = neededPoints(*step, {.fraction = none, .volume = volume});
    for (std::size_t i = 0; i < selection.drawn.size(); ++i) {
        const auto begin = leaves.pointBegin[i], end = begin + selection.drawn[i];
        const bool held = std::any_of(needed.begin(), needed.end(), [&](const auto& range) {
            return range.begin <= begin && end <= range.begin + range.count;
        });
        EXPECT_TRUE(held || begin == end) << i;
    }
}

TEST(StepVolume, CoversWhatIsSeenAndNoMore) {
    const auto step = MemoryStep::make(ball(50000, 3), {.leafCapacity = 32, .volumeLevel = 5});
    const auto volume = stepVolume(*step, shown({{0.0, 0.1}, {1.0, 0.3}}), allPoints());
    const auto toPlot = volume.toPlot();
    for (int axis = 0; axis < 3; ++axis) {
        const double low = toPlot[3][axis], edge = std::ldexp(1.0, -static_cast<int>(volume.level));
        EXPECT_LE(low, 0.2);
        EXPECT_GE(low + toPlot[axis][axis], 0.8);
        // A leaf may reach a cell of level 3 beyond the ball.
        EXPECT_GT(low, 0.2 - 0.125 - 2.0 * edge);
    }
}

TEST(StepVolume, IsEmptyWhereNothingIsSeen) {
    const auto step = MemoryStep::make(ball(1000, 1));
    EXPECT_TRUE(stepVolume(*step, shown({{0.0, 0.0}, {1.0, 0.0}}), allPoints()).empty());
    EXPECT_TRUE(stepVolume(*MemoryStep::make({}), shown({{0.0, 0.5}}), allPoints()).empty());
}

TEST(StepVolume, WithoutTheOctreeItIsThatOfTheStepsOwnCells) {
    const auto step = MemoryStep::make(ball(100000, 4), {.leafCapacity = 32, .volumeLevel = 4});
    const auto transfer = shown({{0.0, 0.1}, {1.0, 0.3}});
    const auto rough = roughStepVolume(*step, transfer);
    EXPECT_EQ(rough.size, glm::uvec3(16));
    for (std::size_t i = 0; i < rough.root.size(); ++i)
        EXPECT_EQ(rough.root[i] > 0.0F, step->volume()[i] > 0.0F);
}

TEST(LeavesByCell, VisitsEachLeafOnceAndThoseOfACellOneAfterTheOther) {
    const auto step = MemoryStep::make(ball(60000, 2), {.leafCapacity = 4, .volumeLevel = 5});
    const LeavesByCell byCell(*step);
    for (const unsigned cells : {0U, 2U, 4U}) {
        std::vector<int> visits(step->leaves().size(), 0);
        // By cell and leaf level: the last place, and whether someone is in the cell.
        std::vector<std::atomic<bool>> busy(std::size_t{1} << (3 * cells));
        std::vector<std::uint64_t> last(busy.size() * 22, 0);
        std::atomic<int> wrong{0};
        byCell.forEach(cells, [&](std::size_t leaf, const CellAt& at) {
            ++visits[leaf];
            const auto node = step->leaves().node[leaf];
            if (at.level < cells) return;  // has cells of its own
            const std::uint64_t morton = step->nodes().morton[node];
            const std::size_t cell = morton >> (3 * (at.level - cells));
            if (busy[cell].exchange(true)) ++wrong;
            if (std::exchange(last[cell * 22 + at.level], morton) > morton) ++wrong;
            busy[cell] = false;
        });
        EXPECT_EQ(wrong, 0) << cells;
        EXPECT_TRUE(std::all_of(visits.begin(), visits.end(), [](int count) { return count == 1; })) << cells;
    }
}

TEST(StepVolume, IsTheSameOnAnyNumberOfThreads) {
    const auto step =
        MemoryStep::make(test::beam({.core = 150000, .halo = 30000, .filaments = 20000, .seed = 4}),
                         {.leafCapacity = 8, .volumeLevel = 5});
    const auto transfer = shown({{0.2, 0.0}, {0.4, 0.1}, {1.0, 0.3}});
    const auto make = [&](int threads) {
        oneapi::tbb::task_arena arena(threads);
        return arena.execute([&] { return stepVolume(*step, transfer, allPoints()); });
    };
    const auto one = make(1);
    EXPECT_FALSE(one.empty());
    for (const int threads : {2, 3, 5}) {
        const auto many = make(threads);
        EXPECT_EQ(many.root, one.root) << threads;
        EXPECT_EQ(many.t, one.t) << threads;
        EXPECT_EQ(many.share, one.share) << threads;
    }
}

TEST(SelectPoints, WeighsPointsByTheMeanOfTheirLeaf) {
    auto points = ball(20000, 5);
    for (auto& point : points) point.weight = point.position.x < 0.5 ? 1.0 : 100.0;
    const auto step = MemoryStep::make(points, {.leafCapacity = 32, .volumeLevel = 4});
    const auto selection = selectPoints(*step, {.meanWeight = 50.5});
    ASSERT_EQ(selection.weights.size(), step->leaves().size());
    const auto nodes = step->nodes();
    for (std::size_t leaf = 0; leaf < selection.weights.size(); ++leaf) {
        // Half of a float keeps a weight to 1 in 256.
        const auto node = step->leaves().node[leaf];
        if (nodes.level[node] == 0) continue;
        const bool heavy = (nodes.morton[node] >> (3 * (nodes.level[node] - 1U)) & 1U) != 0;
        EXPECT_NEAR(static_cast<double>(selection.weightOf(leaf)), (heavy ? 100.0 : 1.0) / 50.5,
                    0.004 * (heavy ? 2.0 : 0.02));
    }
    for (auto& point : points) point.weight = 3.0;
    const auto even = selectPoints(*MemoryStep::make(points), {.meanWeight = 1.5});
    EXPECT_TRUE(even.weights.empty());
    EXPECT_FLOAT_EQ(even.weight, 2.0F);
}

}  // namespace
}  // namespace mote::render
