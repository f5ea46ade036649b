// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <latch>
#include <numeric>
#include <random>
#include <tuple>
#include <vector>

#include "preprocess/on_threads.h"
#include "preprocess/particles/cell_plan.h"
#include "preprocess/particles/octree.h"
#include "preprocess/particles/plot_plan.h"
#include "preprocess/particles/range_builder.h"
#include "preprocess/particles/record_store.h"
#include "storage/particles/octree_check.h"
#include "storage/verify.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/account.h"
#include "tests/unit/particles/job_run.h"
#include "tests/unit/particles/thread_ranks.h"

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
    OctreeOptions options;
    std::vector<RangeTree> ranges;
    Octree tree;
    std::vector<LeafPoint> points;
    std::vector<CellSum> cells;
};

/// What a rank has that sorts the ranges [begin, end).
OctreePart partOf(const Made& made, std::size_t begin, std::size_t end) {
    OctreePart part{made.plan.levels, {}, made.plan.units, made.plan.units.size(), {}};
    if (begin < made.plan.ranges.size()) part.firstUnit = made.plan.ranges[begin].firstUnit;
    if (made.options.maxLevel > made.plan.gridLevel)
        part.below.resize(made.options.maxLevel - made.plan.gridLevel);
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    for (std::size_t range = begin; range < end; ++range) {
        append(part.found, made.ranges[range].units);
        for (std::size_t depth = 0; depth < part.below.size(); ++depth) {
            append(part.below[depth].children, made.ranges[range].levels[depth].children);
            append(part.below[depth].count, made.ranges[range].levels[depth].count);
            append(part.below[depth].weight, made.ranges[range].levels[depth].weight);
        }
    }
    return part;
}

Octree wholeTree(const Made& made) {
    const auto alone = singleProcess();
    auto tree = assembleOctree(partOf(made, 0, made.ranges.size()), *alone);
    EXPECT_TRUE(tree.ok());
    return *std::move(tree);
}

/// What StepBuilder does, in plain steps and all in memory.
Made make(const Run& run, unsigned gridLevel, const OctreeOptions& options, unsigned cellLevel) {
    std::vector<std::uint32_t> counts(std::size_t{1} << (3 * gridLevel));
    for (const auto& particle : run.particles) ++counts[cellOf(particle, gridLevel)];
    Made made;
    made.plan = planCells(counts, gridLevel, options);
    made.options = options;
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
        made.ranges.push_back(
            builder.build(part.particles, {part.weights, 0.0}, units, {options, gridLevel, cellLevel}));
        const auto& tree = made.ranges.back();
        made.points.insert(made.points.end(), builder.points().begin(), builder.points().end());
        made.cells.insert(made.cells.end(), tree.cells.begin(), tree.cells.end());
    }
    made.tree = wholeTree(made);
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

Made makeManyLeaves(bool weighted, int threads) {
    auto run = randomRun(600000, 3);
    // Eight times the weight has the same density a level higher.
    for (std::size_t i = 0; !weighted && i < run.weights.size(); ++i)
        run.weights[i] = std::ldexp(2.0, 3 * static_cast<int>(i % 3));
    const OctreeOptions options{1, 12};
    tbb::task_arena arena(threads);
    return arena.execute([&] { return make(run, 7, options, 7); });
}

/// More leaves than one thread sorts, or counts, at once.
TEST(Octree, LeavesOfManyBlocksAreInOrder) {
    for (const bool weighted : {false, true}) {
        SCOPED_TRACE(weighted);
        const auto made = makeManyLeaves(weighted, 1);
        const auto& tree = made.tree;
        std::vector<std::uint32_t> nodes;
        for (std::uint32_t node = 0; node < tree.level.size(); ++node) {
            if (tree.childCount[node] == 0) nodes.push_back(node);
        }
        ASSERT_GT(nodes.size(), std::size_t{3} << 17);
        std::ranges::sort(nodes, {}, [&](std::uint32_t node) {
            return std::tuple(tree.density[node], tree.morton[node], tree.level[node]);
        });
        EXPECT_TRUE(nodes == tree.leafNode);
        std::uint64_t before = 0;
        Range densities;
        for (std::size_t leaf = 0; leaf < nodes.size(); ++leaf) {
            ASSERT_EQ(tree.leafPointBegin[leaf], before) << leaf;
            ASSERT_EQ(tree.firstChild[nodes[leaf]], leaf);
            before += tree.leafPointCount[leaf];
            if (tree.count[nodes[leaf]] < counted) continue;
            const double density = tree.density[nodes[leaf]];
            densities = densities.united({density, density});
        }
        std::uint32_t child = 1;
        for (std::size_t node = 0; node < tree.level.size(); ++node) {
            if (tree.childCount[node] == 0) continue;
            ASSERT_EQ(tree.firstChild[node], child);
            child += tree.childCount[node];
        }
        const auto others = makeManyLeaves(weighted, 3).tree;
        EXPECT_TRUE(others.leafNode == tree.leafNode && others.firstChild == tree.firstChild);
        EXPECT_TRUE(others.leafSource == tree.leafSource && others.leafPointBegin == tree.leafPointBegin);
        EXPECT_EQ(others.toldDensities, tree.toldDensities);
        EXPECT_EQ(tree.toldDensities.max, densities.max);
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
    OctreePart part;
    part.top.resize(1);
    part.top[0].add(1);
    part.units.push_back({0, false, 1, 0, 0});
    part.found.push_back({1e39, 0});
    EXPECT_FALSE(assembleOctree(part, *singleProcess()).ok());
    // Of one rank alone, the other having nothing: both learn of it.
    test::ThreadRanks ranks(2);
    std::atomic<int> failed{0};
    ranks.run([&](Communicator& own) {
        OctreePart mine = part;
        if (own.rank() == 1) {
            mine.found.clear();
            mine.firstUnit = 1;
        }
        if (!assembleOctree(mine, own).ok()) ++failed;
    });
    EXPECT_EQ(failed, 2);
}

/// What the ranks hold, as one octree again; each node and leaf must be in one of them.
Octree joinedTree(const std::vector<Octree>& parts) {
    Octree all;
    const auto join = [&]<class T>(std::vector<T> Octree::*list, const Octree& part) {
        (all.*list).resize(parts[0].nodeTotal);
        for (const auto& run : part.runs) {
            const auto from = (part.*list).begin() + static_cast<std::ptrdiff_t>(run.first);
            std::copy_n(from, run.count, (all.*list).begin() + static_cast<std::ptrdiff_t>(run.place));
        }
    };
    std::vector<int> seen(parts[0].nodeTotal);
    for (const auto& part : parts) {
        EXPECT_EQ(part.leafBefore, all.leafNode.size());
        EXPECT_EQ(part.leafTotal, parts[0].leafTotal);
        EXPECT_EQ(part.slicePoint, parts[0].slicePoint);
        EXPECT_EQ(part.toldDensities, parts[0].toldDensities);
        EXPECT_EQ(part.leafDensities, parts[0].leafDensities);
        EXPECT_EQ(part.totalWeight, parts[0].totalWeight);
        for (const auto& run : part.runs) {
            for (std::size_t i = 0; i < run.count; ++i) ++seen[run.place + i];
        }
        join(&Octree::level, part);
        join(&Octree::morton, part);
        join(&Octree::firstChild, part);
        join(&Octree::childCount, part);
        join(&Octree::count, part);
        join(&Octree::density, part);
        join(&Octree::minDensity, part);
        const auto append = [&](auto list) {
            (all.*list).insert((all.*list).end(), (part.*list).begin(), (part.*list).end());
        };
        append(&Octree::leafNode);
        append(&Octree::leafPointBegin);
        append(&Octree::leafPointCount);
        append(&Octree::leafDensity);
        append(&Octree::leafSource);
        append(&Octree::leafCell);
    }
    EXPECT_EQ(all.leafNode.size(), parts[0].leafTotal);
    EXPECT_EQ(std::ranges::count(seen, 1), static_cast<std::ptrdiff_t>(seen.size()));
    return all;
}

void expectSame(const Octree& a, const Octree& b) {
    EXPECT_TRUE(a.level == b.level && a.morton == b.morton && a.count == b.count);
    EXPECT_TRUE(a.firstChild == b.firstChild && a.childCount == b.childCount);
    EXPECT_TRUE(a.density == b.density && a.minDensity == b.minDensity);
    EXPECT_TRUE(a.leafNode == b.leafNode && a.leafPointBegin == b.leafPointBegin);
    EXPECT_TRUE(a.leafPointCount == b.leafPointCount && a.leafDensity == b.leafDensity);
    EXPECT_TRUE(a.leafSource == b.leafSource && a.leafCell == b.leafCell);
}

/// `cuts`: each rank's first range, and one more.
std::vector<Octree> assembledBy(const Made& made, const std::vector<std::size_t>& cuts) {
    std::vector<Octree> parts(cuts.size() - 1);
    test::ThreadRanks ranks(parts.size());
    ranks.run([&](Communicator& own) {
        const auto rank = static_cast<std::size_t>(own.rank());
        auto tree = assembleOctree(partOf(made, cuts[rank], cuts[rank + 1]), own);
        EXPECT_TRUE(tree.ok());
        if (tree.ok()) parts[rank] = *std::move(tree);
    });
    return parts;
}

/// However its ranges are shared out, also where ranks have none.
TEST(Octree, OfAnyNumberOfPartsIsTheWhole) {
    std::mt19937_64 random(20);
    for (const std::size_t particles : {0U, 1U, 20000U, 300000U}) {
        for (const auto& [grid, maxLevel, capacity] :
             {std::tuple(1U, 0U, 8U), {2U, 1U, 8U}, {2U, 2U, 1U}, {4U, 6U, 1U}, {5U, 9U, 20U}}) {
            const auto run = randomRun(particles, random());
            const auto made = make(run, grid, {capacity, maxLevel}, grid);
            EXPECT_EQ(made.tree.nodeTotal, made.tree.level.size());
            EXPECT_EQ(made.tree.runs, (std::vector<NodeRun>{{0, made.tree.level.size(), 0}}));
            for (const std::size_t ranks : {1U, 2U, 3U, 5U}) {
                SCOPED_TRACE(testing::Message()
                             << particles << ' ' << grid << ' ' << maxLevel << ' ' << ranks);
                std::vector<std::size_t> cuts{0, made.ranges.size()};
                while (cuts.size() <= ranks) cuts.push_back(random() % (made.ranges.size() + 1));
                std::ranges::sort(cuts);
                const auto parts = assembledBy(made, cuts);
                expectSame(joinedTree(parts), made.tree);
                EXPECT_EQ(parts[0].toldDensities, made.tree.toldDensities);
                EXPECT_EQ(parts[0].leafDensities, made.tree.leafDensities);
                EXPECT_EQ(parts[0].totalWeight, made.tree.totalWeight);
            }
        }
    }
}

/// Slices are about equal, and no rank holds much more than its share below the grid.
TEST(Octree, RanksHoldAboutAsMuch) {
    const auto made = make(randomRun(300000, 4), 4, {4, 9}, 4);
    const std::size_t ranges = made.ranges.size();
    ASSERT_GT(ranges, 4U);
    const auto parts = assembledBy(made, {0, ranges / 3, 2 * ranges / 3, ranges});
    for (std::size_t rank = 0; rank < 3; ++rank) {
        const auto points = parts[0].slicePoint[rank + 1] - parts[0].slicePoint[rank];
        // A third of the particles are one leaf, which is one slice's.
        EXPECT_LT(points, 220000U);
        EXPECT_LT(parts[rank].level.size(), made.tree.level.size());
    }
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

Error failure() {
    return {ErrorCode::internal, "", "it failed"};
}

TEST(TwoStages, TakeTheItemsInTheirOrder) {
    std::vector<std::size_t> made, taken;
    const auto status = inTwoStages(
        100, 2,
        [&](std::size_t i) {
            made.push_back(i);
            return Result<std::size_t>(10 * i);
        },
        [&](std::size_t i, std::size_t value) {
            EXPECT_EQ(value, 10 * i);
            taken.push_back(i);
            return success();
        });
    EXPECT_TRUE(status.ok());
    ASSERT_EQ(taken.size(), 100U);
    EXPECT_TRUE(std::is_sorted(made.begin(), made.end()));
    EXPECT_TRUE(std::is_sorted(taken.begin(), taken.end()));
    EXPECT_TRUE(inTwoStages(
                    0, 2, [](std::size_t) { return Result<int>(failure()); },
                    [](std::size_t, int) { return Status(failure()); })
                    .ok());
}

TEST(TwoStages, TheNextIsMadeWhileOneIsTaken) {
    std::latch both(2);  // each stage waits for the other: they can only go on together
    const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);  // also on one core
    tbb::task_arena arena(2);
    arena.execute([&] {
        const auto status = inTwoStages(
            2, 2,
            [&](std::size_t i) {
                if (i == 1) both.arrive_and_wait();
                return Result<int>(0);
            },
            [&](std::size_t i, int) {
                if (i == 0) both.arrive_and_wait();
                return success();
            });
        EXPECT_TRUE(status.ok());
    });
}

TEST(TwoStages, NoMoreAreUnderWayThanAllowed) {
    for (const std::size_t together : {1U, 2U}) {
        std::atomic<std::size_t> underWay{0}, most{0};
        const auto status = inTwoStages(
            200, together,
            [&](std::size_t) {
                most = std::max(most.load(), ++underWay);
                return Result<int>(0);
            },
            [&](std::size_t, int) {
                --underWay;
                return success();
            });
        EXPECT_TRUE(status.ok());
        EXPECT_LE(most, together);
    }
}

TEST(TwoStages, WhatWasUnderWayAtAnErrorIsNotTaken) {
    std::latch begun(1);
    std::vector<std::size_t> taken;
    const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);  // also on one core
    tbb::task_arena arena(2);
    arena.execute([&] {
        const auto status = inTwoStages(
            3, 2,
            [&](std::size_t i) {
                if (i == 1) begun.count_down();
                return Result<int>(0);
            },
            [&](std::size_t i, int) -> Status {
                taken.push_back(i);
                begun.wait();
                return failure();
            });
        EXPECT_FALSE(status.ok());
    });
    EXPECT_EQ(taken, std::vector<std::size_t>{0});
}

TEST(TwoStages, TheFirstErrorEndsIt) {
    for (const bool inFirst : {true, false}) {
        std::vector<std::size_t> taken;
        std::size_t made = 0;
        const auto status = inTwoStages(
            100, 2,
            [&](std::size_t i) -> Result<int> {
                ++made;
                if (inFirst && i == 7) return failure();
                return 0;
            },
            [&](std::size_t i, int) -> Status {
                taken.push_back(i);
                if (!inFirst && i == 7) return failure();
                return success();
            });
        ASSERT_FALSE(status.ok());
        EXPECT_EQ(status.error().message, "it failed");
        EXPECT_EQ(taken.size(), inFirst ? 7U : 8U);
        EXPECT_LE(made, 9U) << "one more may have been under way";
    }
}

// The job where its particles do not fit the memory that it may take.

using test::beamStep;
using test::contentOf;
using test::entriesOf;
using test::FakeSource;
using test::make;
using test::requestFor;
using testing::HasSubstr;

constexpr int threads = 2;
const StepOptions defaults = stepOptionsOf({});

/// So little that particles must lie in a file, and yet enough.
std::uint64_t littleMemory(std::uint64_t particles) {
    return planMemory(particles, defaults, std::uint64_t{1} << 40, threads).needed + 1024;
}

TEST(RecordStore, GivesBackWhatWasWrittenWhereverItLies) {
    const test::TempDir dir;
    constexpr std::uint64_t count = 10000;
    for (const bool inFile : {false, true}) {
        auto store = inFile ? RecordStore::inFile(dir.path(), count * 8)
                            : RecordStore::inMemory(count * 8, std::make_shared<StoreMemory>());
        ASSERT_TRUE(store.ok());
        std::vector<std::uint64_t> values(100);
        for (std::uint64_t first = 0; first < count; first += 100) {
            for (std::size_t i = 0; i < 100; ++i) values[i] = 3 * (first + i);
            ASSERT_TRUE(store->write<std::uint64_t>(first, values).ok());
        }
        std::vector<std::uint64_t> buffer;
        for (const std::uint64_t first : {0UL, 77UL, 9900UL}) {
            const auto read = store->read(first, 100, buffer);
            ASSERT_TRUE(read.ok());
            for (std::size_t i = 0; i < 100; ++i) ASSERT_EQ((*read)[i], 3 * (first + i));
        }
        // No name, so nothing that could be left.
        EXPECT_EQ(entriesOf(dir.path()), 0U);
        EXPECT_TRUE(store->read(0, 0, buffer)->empty());
    }
    EXPECT_EQ(RecordStore::inFile(dir / "nowhere", 8).error().code, ErrorCode::notFound);
}

TEST(RecordStore, TheNextHasTheMemoryOfThoseBefore) {
    const auto memory = std::make_shared<StoreMemory>();
    constexpr std::uint64_t large = std::uint64_t{1} << 21;
    const auto take = [&](std::uint64_t pages) { return *RecordStore::inMemory(pages * large, memory); };
    {
        auto first = take(3), second = take(2);
        first.room<std::uint64_t>(0, 1)[0] = 77;
        EXPECT_EQ(memory->kept(), 0U);
    }
    EXPECT_EQ(memory->kept(), 5 * large);
    {
        // The one that fits; it is as it was left.
        auto again = take(3);
        EXPECT_EQ(again.room<std::uint64_t>(0, 1)[0], 77U);
        EXPECT_EQ(memory->kept(), 2 * large);
    }
    {
        // Made longer, and what is kept beside it gone: together they would be more than was ever used.
        auto longer = take(4);
        EXPECT_EQ(longer.room<std::uint64_t>(0, 1)[0], 77U);
        EXPECT_EQ(memory->kept(), 0U);
        longer.room<std::uint64_t>(0, 4 * large / 8).back() = 1;
    }
    EXPECT_EQ(memory->kept(), 4 * large);
}

TEST(Spill, TheBytesAreThoseOfAJobInMemory) {
    const test::TempDir dir;
    auto even = beamStep(50000, 2);
    even[Column::weight].assign(50000, 0.25);
    FakeSource source({beamStep(300000, 1), even});
    ASSERT_TRUE(make(requestFor(), source, dir / "memory.mote", {threads, 0}).ok());
    const auto spilled = make(requestFor(), source, dir / "file.mote", {threads, littleMemory(300000)});
    ASSERT_TRUE(spilled.ok()) << spilled.error().toString();
    EXPECT_TRUE(contentOf(dir / "file.mote") == contentOf(dir / "memory.mote"));
    EXPECT_TRUE(storage::verifyDataset(dir / "file.mote").empty());
    test::expectAccounted(dir / "file.mote", requestFor().particles(), source);
    EXPECT_EQ(entriesOf(dir.path()), 2U);
}

TEST(Spill, AFullDiskIsOneErrorAndNoDebris) {
    const test::TempDir dir;
    FakeSource source({beamStep(20000, 1)});
    // Of the temporary file; of the step's, which is larger.
    for (const rlim_t bytes : {100000UL, 500000UL}) {
        const test::FileSizeLimit limit(bytes);
        const auto made = make(requestFor(), source, dir / "a.mote", {threads, littleMemory(20000)});
        ASSERT_FALSE(made.ok());
        EXPECT_EQ(made.error().code, ErrorCode::resourceExhausted) << made.error().toString();
        EXPECT_EQ(entriesOf(dir.path()), 0U);
    }
}

TEST(Spill, CancelledAnywhereLeavesNoDebris) {
    const test::TempDir dir;
    bool done = false;
    for (long after = 0; !done; ++after) {
        FakeSource source({beamStep(2000, 1)});
        test::QuietProgress progress(after);
        const auto made = runParticlesJob(requestFor(), source, {dir / "fake.h5"}, dir / "a.mote",
                                          {threads, littleMemory(2000)}, progress);
        done = made.ok();
        if (done) continue;
        EXPECT_EQ(made.error().code, ErrorCode::cancelled);
        EXPECT_EQ(entriesOf(dir.path()), 0U);
    }
}

TEST(Spill, WhatIsNeededIsSaidAndIsEnough) {
    const test::TempDir dir;
    FakeSource source({beamStep(20000, 1)});
    const auto needed = planMemory(20000, defaults, std::uint64_t{1} << 40, threads).needed;
    const auto refused = make(requestFor(), source, dir / "a.mote", {threads, needed - 1});
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::resourceExhausted);
    EXPECT_THAT(refused.error().message, HasSubstr("needs at least 0.02 GB"));
    EXPECT_TRUE(make(requestFor(), source, dir / "a.mote", {threads, needed + 1024}).ok());
}

TEST(Spill, WhatTheSourceKeepsIsNeededToo) {
    constexpr std::uint64_t perThread = 50'000'000;
    const test::TempDir dir;
    FakeSource source({beamStep(20000, 1)});
    source.keep(perThread);
    const auto needed =
        planMemory(20000, defaults, std::uint64_t{1} << 40, threads).needed + threads * perThread;
    const auto refused = make(requestFor(), source, dir / "a.mote", {threads, needed - 1});
    ASSERT_FALSE(refused.ok());
    EXPECT_THAT(refused.error().message, HasSubstr("needs at least 0.12 GB"));
    EXPECT_TRUE(make(requestFor(), source, dir / "a.mote", {threads, needed + 1024}).ok());
}

}  // namespace
}  // namespace mote::prep
