// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/octree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <tuple>

#include "preprocess/particles/cell_plan.h"
#include "preprocess/particles/range_builder.h"
#include "storage/particles/octree_check.h"

namespace mote::prep {
namespace {

TEST(Morton, AxesAndBack) {
    EXPECT_EQ(mortonKey(1, 0, 0), 1U);
    EXPECT_EQ(mortonKey(0, 1, 0), 2U);
    EXPECT_EQ(mortonKey(0, 0, 1), 4U);
    std::mt19937_64 random(1);
    for (int i = 0; i < 1000; ++i) {
        const std::array<std::uint32_t, 3> cell{static_cast<std::uint32_t>(random() & 0xffff),
                                                static_cast<std::uint32_t>(random() & 0xffff),
                                                static_cast<std::uint32_t>(random() & 0xffff)};
        const auto key = mortonKey(cell[0], cell[1], cell[2]);
        EXPECT_EQ(mortonCell(key), cell);
        EXPECT_EQ(key >> 3, mortonKey(cell[0] >> 1, cell[1] >> 1, cell[2] >> 1));
    }
}

struct Run {
    std::vector<Particle> particles;
    std::vector<double> weights;
};

/// Particles by row, a third of them in one cell.
Run randomRun(std::size_t size, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    Run run;
    for (std::size_t i = 0; i < size; ++i) {
        const auto at = [&] { return i % 3 == 0 ? 7U : static_cast<std::uint32_t>(random()); };
        run.particles.push_back({at(), at(), at(), static_cast<std::uint32_t>(i)});
        run.weights.push_back(1.0 + static_cast<double>(i % 5));
    }
    return run;
}

struct Made {
    CellPlan plan;
    Octree tree;
    std::vector<LeafPoint> points;
    std::vector<CellSum> cells;
};

/// What StepBuilder does, in plain steps and all in memory.
Made make(const Run& run, unsigned gridLevel, const OctreeOptions& options, unsigned cellLevel) {
    std::vector<std::uint32_t> counts(std::size_t{1} << (3 * gridLevel));
    for (const auto& particle : run.particles) ++counts[cellOf(particle, gridLevel)];
    Made made;
    made.plan = planCells(counts, gridLevel, options);
    auto levels = made.plan.levels;
    if (options.maxLevel > gridLevel) levels.resize(options.maxLevel + 1);
    RangeBuilder builder;
    for (std::size_t range = 0; range < made.plan.ranges.size(); ++range) {
        const auto& planned = made.plan.ranges[range];
        Run part;
        for (std::size_t i = 0; i < run.particles.size(); ++i) {
            if (made.plan.rangeOfCell[cellOf(run.particles[i], gridLevel)] != range) continue;
            part.particles.push_back(run.particles[i]);
            part.weights.push_back(run.weights[i]);
        }
        EXPECT_EQ(part.particles.size(), planned.count);
        const auto units = std::span(made.plan.units).subspan(planned.firstUnit, planned.unitCount);
        const auto tree =
            builder.build(part.particles, {part.weights, 0.0}, units, {options, gridLevel, cellLevel});
        for (std::size_t i = 0; i < units.size(); ++i) {
            levels[units[i].level].weight[units[i].index] = tree.units[i].weight;
            levels[units[i].level].children[units[i].index] |= tree.units[i].children;
        }
        for (std::size_t depth = 0; depth < tree.levels.size(); ++depth) {
            auto& level = levels[gridLevel + 1 + depth];
            const auto& more = tree.levels[depth];
            level.children.insert(level.children.end(), more.children.begin(), more.children.end());
            level.count.insert(level.count.end(), more.count.begin(), more.count.end());
            level.weight.insert(level.weight.end(), more.weight.begin(), more.weight.end());
        }
        made.points.insert(made.points.end(), builder.points().begin(), builder.points().end());
        made.cells.insert(made.cells.end(), tree.cells.begin(), tree.cells.end());
    }
    auto tree = assembleOctree(std::move(levels));
    EXPECT_TRUE(tree.ok());
    made.tree = *std::move(tree);
    return made;
}

TEST(Octree, IsWhatTheReaderChecksAndRespectsItsLimits) {
    const auto run = randomRun(5000, 1);
    const double weight = std::accumulate(run.weights.begin(), run.weights.end(), 0.0);
    for (const unsigned grid : {1U, 2U, 5U}) {
        for (const std::uint32_t maxLevel : {0U, 1U, 3U, 6U, 16U}) {
            for (const std::uint32_t capacity : {1U, 8U, 1000000U}) {
                SCOPED_TRACE(testing::Message() << grid << ' ' << maxLevel << ' ' << capacity);
                const auto tree = make(run, grid, {capacity, maxLevel}, grid).tree;
                const auto checked = storage::checkOctree(tree.nodes(), tree.leaves(), 5000, maxLevel);
                ASSERT_TRUE(checked.ok()) << checked.error().toString();
                for (std::size_t i = 0; i < tree.level.size(); ++i) {
                    const bool mustDivide = tree.count[i] > capacity && tree.level[i] < maxLevel;
                    EXPECT_EQ(tree.childCount[i] > 0, mustDivide);
                }
                EXPECT_DOUBLE_EQ(tree.totalWeight, weight);
            }
        }
    }
}

/// Many particles make several ranges; the grid changes nothing of the octree.
TEST(Octree, IsTheSameForAnyGrid) {
    const auto run = randomRun(200000, 2);
    const OctreeOptions options{20, 8};
    const auto expected = make(run, 1, options, 6);
    for (const unsigned grid : {3U, 5U, 7U}) {
        SCOPED_TRACE(grid);
        const auto made = make(run, grid, options, 7);
        EXPECT_GT(made.plan.ranges.size(), 2U);
        EXPECT_EQ(made.tree.level, expected.tree.level);
        EXPECT_EQ(made.tree.morton, expected.tree.morton);
        EXPECT_EQ(made.tree.density, expected.tree.density);
        EXPECT_EQ(made.tree.leafNode, expected.tree.leafNode);
        EXPECT_EQ(made.tree.leafSource, expected.tree.leafSource);
        EXPECT_TRUE(std::equal(
            made.points.begin(), made.points.end(), expected.points.begin(),
            [](const auto& a, const auto& b) { return a.row == b.row && a.position.x == b.position.x; }));
    }
}

void checkLeaves(const Run& run, const Made& made) {
    const auto& tree = made.tree;
    std::vector<int> seen(run.particles.size());
    for (std::size_t leaf = 0; leaf < tree.leafNode.size(); ++leaf) {
        const auto node = tree.leafNode[leaf];
        double weight = 0.0;
        for (std::uint64_t i = 0; i < tree.leafPointCount[leaf]; ++i) {
            const auto row = made.points[tree.leafSource[leaf] + i].row;
            ++seen[row];
            weight += run.weights[row];
            EXPECT_EQ(cellOf(run.particles[row], tree.level[node]), tree.morton[node]);
        }
        EXPECT_FLOAT_EQ(tree.leafDensity[leaf], static_cast<float>(weight * std::pow(8.0, tree.level[node])));
        if (leaf == 0) continue;
        const auto before = tree.leafNode[leaf - 1];
        EXPECT_LE(std::tie(tree.density[before], tree.morton[before], tree.level[before]),
                  std::tie(tree.density[node], tree.morton[node], tree.level[node]));
    }
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(seen.size()));
}

TEST(Octree, LeavesHoldTheParticlesOfTheirCellsAndOrderByDensity) {
    auto run = randomRun(3000, 3);
    // The deepest keys that there are: their bits and an index are more than one number holds.
    for (const std::uint32_t maxLevel : {5U, 16U}) checkLeaves(run, make(run, 2, {4, maxLevel}, 2));
    // Leaves of two to nine levels that are equally dense.
    for (const unsigned levels : {2U, 3U, 5U, 9U}) {
        for (std::size_t i = 0; i < run.weights.size(); ++i) {
            run.weights[i] = std::pow(8.0, static_cast<double>(i * 7919 % levels));
        }
        checkLeaves(run, make(run, 2, {1, 16}, 2));
    }
}

TEST(Octree, OfNothingIsARootWithAnEmptyLeaf) {
    const auto tree = make({}, 1, {32, 6}, 1).tree;
    EXPECT_EQ(tree.level.size(), 1U);
    EXPECT_EQ(tree.leafPointCount, std::vector<std::uint32_t>{0});
    EXPECT_TRUE(storage::checkOctree(tree.nodes(), tree.leaves(), 0, 6).ok());
}

TEST(Octree, DensitiesBeyondSinglePrecisionAreAnError) {
    OctreeLevels levels(1);
    levels[0].add(1);
    levels[0].weight[0] = 1e39;
    EXPECT_FALSE(assembleOctree(levels).ok());
}

TEST(DensityVolume, EqualsAPlainHistogram) {
    const auto run = randomRun(200000, 5);
    for (const unsigned level : {1U, 4U, 8U}) {
        const std::size_t size = 1UL << level;
        std::vector<double> expected(size * size * size);
        for (std::size_t i = 0; i < run.particles.size(); ++i) {
            const auto cell = mortonCell(cellOf(run.particles[i], level));
            expected[(cell[2] * size + cell[1]) * size + cell[0]] += run.weights[i];
        }
        const unsigned cellLevel = std::max(level, 5U);
        const auto made = make(run, 5, {32, 7}, cellLevel);
        std::vector<double> sums(size * size * size);
        addCells(made.cells, cellLevel, level, sums);
        const auto volume = densityVolume(sums, level);
        for (std::size_t i = 0; i < volume.size(); ++i) {
            // Weights are small integers: their sums are exact.
            ASSERT_EQ(volume[i], static_cast<float>(expected[i] * std::pow(8.0, level)));
        }
    }
}

}  // namespace
}  // namespace mote::prep
