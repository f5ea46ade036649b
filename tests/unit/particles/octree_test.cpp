// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "preprocess/particles/density_volume.h"
#include "preprocess/particles/morton.h"
#include "preprocess/particles/octree.h"
#include "preprocess/particles/radix_sort.h"
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

class RadixSort : public testing::TestWithParam<unsigned> {};

TEST_P(RadixSort, IsAStableSort) {
    const unsigned bits = GetParam();
    std::mt19937_64 random(bits);
    // More than one block, and many equal keys.
    for (const std::size_t size : {0UL, 1UL, 2UL, 1000UL, 600000UL}) {
        KeyedIndices items;
        for (std::size_t i = 0; i < size; ++i) {
            items.key.push_back((random() >> 8) & ((1ULL << bits) - 1) & ~0xfULL);
            items.index.push_back(static_cast<std::uint32_t>(i));
        }
        std::vector<std::pair<std::uint64_t, std::uint32_t>> expected;
        for (std::size_t i = 0; i < size; ++i) expected.emplace_back(items.key[i], items.index[i]);
        std::sort(expected.begin(), expected.end());
        radixSort(items, bits);
        for (std::size_t i = 0; i < size; ++i) {
            ASSERT_EQ(items.key[i], expected[i].first);
            ASSERT_EQ(items.index[i], expected[i].second);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Bits, RadixSort, testing::Values(3U, 9U, 30U, 48U));

struct Sorted {
    std::vector<std::uint64_t> keys;
    std::vector<double> weights;
};

Sorted randomParticles(std::size_t size, unsigned keyLevel, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    Sorted sorted;
    for (std::size_t i = 0; i < size; ++i) {
        // A third of them in one cell.
        sorted.keys.push_back(i % 3 == 0 ? 7 : random() & ((1ULL << (3 * keyLevel)) - 1));
        sorted.weights.push_back(1.0 + static_cast<double>(i % 5));
    }
    std::sort(sorted.keys.begin(), sorted.keys.end());
    return sorted;
}

TEST(Octree, IsWhatTheReaderChecksAndRespectsItsLimits) {
    for (const std::uint32_t maxLevel : {0U, 1U, 3U, 6U, 16U}) {
        for (const std::uint32_t capacity : {1U, 8U, 1000000U}) {
            const unsigned keyLevel = std::max(maxLevel, 2U);
            const auto sorted = randomParticles(5000, keyLevel, maxLevel);
            const auto tree = buildOctree(sorted.keys, sorted.weights, keyLevel, {capacity, maxLevel});
            ASSERT_TRUE(tree.ok());
            const auto checked = storage::checkOctree(tree->nodes(), tree->leaves(), 5000, maxLevel);
            ASSERT_TRUE(checked.ok()) << checked.error().toString();
            for (std::size_t i = 0; i < tree->level.size(); ++i) {
                const bool mustDivide = tree->count[i] > capacity && tree->level[i] < maxLevel;
                EXPECT_EQ(tree->childCount[i] > 0, mustDivide);
            }
            EXPECT_DOUBLE_EQ(tree->totalWeight,
                             std::accumulate(sorted.weights.begin(), sorted.weights.end(), 0.0));
        }
    }
}

TEST(Octree, LeavesHoldTheParticlesOfTheirCellsAndOrderByDensity) {
    const unsigned keyLevel = 5;
    const auto sorted = randomParticles(3000, keyLevel, 3);
    const auto tree = *buildOctree(sorted.keys, sorted.weights, keyLevel, {4, 5});
    std::vector<int> seen(sorted.keys.size());
    for (std::size_t leaf = 0; leaf < tree.leafNode.size(); ++leaf) {
        const auto node = tree.leafNode[leaf];
        double weight = 0.0;
        for (std::uint64_t i = 0; i < tree.leafPointCount[leaf]; ++i) {
            const auto at = tree.leafSource[leaf] + i;
            ++seen[at];
            weight += sorted.weights[at];
            EXPECT_EQ(sorted.keys[at] >> (3 * (keyLevel - tree.level[node])), tree.morton[node]);
        }
        EXPECT_FLOAT_EQ(tree.leafDensity[leaf], static_cast<float>(weight * std::pow(8.0, tree.level[node])));
        if (leaf == 0) continue;
        const auto before = tree.leafNode[leaf - 1];
        EXPECT_LE(std::tie(tree.density[before], tree.morton[before], tree.level[before]),
                  std::tie(tree.density[node], tree.morton[node], tree.level[node]));
    }
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), 3000);
}

TEST(Octree, OfNothingIsARootWithAnEmptyLeaf) {
    const auto tree = *buildOctree({}, {}, 6, {32, 6});
    EXPECT_EQ(tree.level.size(), 1U);
    EXPECT_EQ(tree.leafPointCount, std::vector<std::uint32_t>{0});
    EXPECT_TRUE(storage::checkOctree(tree.nodes(), tree.leaves(), 0, 6).ok());
}

TEST(Octree, DensitiesBeyondSinglePrecisionAreAnError) {
    const std::vector<std::uint64_t> keys{0};
    const std::vector<double> weights{1e39};
    EXPECT_FALSE(buildOctree(keys, weights, 1, {1, 1}).ok());
}

TEST(DensityVolume, EqualsAPlainHistogram) {
    const unsigned keyLevel = 8;
    // More than one block of 2^16, and one cell that spans several.
    const auto sorted = randomParticles(400000, keyLevel, 5);
    for (const unsigned level : {1U, 4U, 8U}) {
        const std::size_t size = 1UL << level;
        std::vector<double> expected(size * size * size);
        for (std::size_t i = 0; i < sorted.keys.size(); ++i) {
            const auto cell = mortonCell(sorted.keys[i] >> (3 * (keyLevel - level)));
            expected[(cell[2] * size + cell[1]) * size + cell[0]] += sorted.weights[i];
        }
        const auto volume = densityVolume(sorted.keys, sorted.weights, keyLevel, level);
        for (std::size_t i = 0; i < volume.size(); ++i) {
            // Weights are small integers: their sums are exact.
            ASSERT_EQ(volume[i], static_cast<float>(expected[i] * std::pow(8.0, level)));
        }
    }
}

}  // namespace
}  // namespace mote::prep
