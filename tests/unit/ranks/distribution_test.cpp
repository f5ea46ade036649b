// SPDX-License-Identifier: GPL-3.0-or-later
//
// How leaves and tiles are distributed to ranks: nothing is lost, nothing is drawn twice, nobody has much
// more than others.
#include <gtest/gtest.h>

#include <random>

#include "server/render/plan/point_selection.h"
#include "server/render/ranks/distribution.h"

namespace mote::render {
namespace {

class LeafDistributionTest : public testing::TestWithParam<std::tuple<std::size_t, int>> {};

TEST_P(LeafDistributionTest, EachLeafInViewIsOneRanks) {
    const auto [leaves, ranks] = GetParam();
    const LeafDistribution distribution(leaves, ranks);
    std::mt19937_64 random(leaves);
    std::vector<std::uint64_t> inView((leaves + 63) / 64);
    for (auto& word : inView) word = random();
    std::vector<std::vector<std::uint64_t>> own, ofAll;
    for (int rank = 0; rank < ranks; ++rank) {
        own.push_back(distribution.own(inView, leaves, rank));
        ofAll.push_back(distribution.own({}, leaves, rank));
    }
    for (std::size_t leaf = 0; leaf < leaves; ++leaf) {
        for (int rank = 0; rank < ranks; ++rank) {
            const bool mine = distribution.owner(leaf) == rank;
            const auto at = static_cast<std::size_t>(rank);
            ASSERT_EQ(own[at][leaf / 64] >> (leaf % 64) & 1, mine && render::inView(inView, leaf) ? 1 : 0);
            ASSERT_EQ(ofAll[at][leaf / 64] >> (leaf % 64) & 1, mine ? 1 : 0);
        }
    }
}

TEST_P(LeafDistributionTest, RanksHaveNearlyAsMuch) {
    const auto [leaves, ranks] = GetParam();
    const LeafDistribution distribution(leaves, ranks);
    std::vector<std::size_t> counts(static_cast<std::size_t>(ranks));
    for (std::size_t leaf = 0; leaf < leaves; ++leaf)
        ++counts[static_cast<std::size_t>(distribution.owner(leaf))];
    const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
    EXPECT_LE(*most - *least, distribution.run());
    // A run is at most a 32nd of a fair share, unless it has its least length.
    EXPECT_TRUE(distribution.run() == 64 ||
                distribution.run() * 32 <= leaves / static_cast<std::size_t>(ranks));
}

INSTANTIATE_TEST_SUITE_P(Sizes, LeafDistributionTest,
                         testing::Combine(testing::Values(1, 63, 64, 65, 1000, 123457),
                                          testing::Values(1, 2, 3, 8)));

TEST(LeafDistribution, RunsAreBounded) {
    EXPECT_EQ(LeafDistribution(0, 4).run(), 64u);
    EXPECT_EQ(LeafDistribution(std::size_t{1} << 40, 2).run(), std::size_t{1} << 17);
}

class TileDistributionTest : public testing::TestWithParam<int> {};

TEST_P(TileDistributionTest, BatchesHoldEachTileOnce) {
    const TileDistribution distribution(1280, 720, TileDistribution::batchBytes / 100, GetParam());
    EXPECT_EQ(distribution.tiles, 40u * 23u);
    EXPECT_EQ(distribution.batch, 100u);
    std::vector<int> seen(distribution.tiles);
    for (std::uint32_t begin = 0; begin < distribution.tiles; begin += distribution.batch) {
        const std::uint32_t end = std::min(distribution.tiles, begin + distribution.batch);
        for (std::uint32_t rank = 0; rank < distribution.ranks; ++rank) {
            std::uint32_t count = 0;
            for (auto tile = distribution.firstOf(rank, begin); tile < end;
                 tile += distribution.ranks, ++count) {
                EXPECT_EQ(distribution.owner(tile), rank);
                ++seen[tile];
            }
            EXPECT_EQ(distribution.countOf(rank, begin, end), count);
        }
    }
    EXPECT_EQ(seen, std::vector<int>(distribution.tiles, 1));
}

INSTANTIATE_TEST_SUITE_P(Ranks, TileDistributionTest, testing::Values(1, 2, 3, 7, 64));

TEST(TileDistribution, ABatchIsNeverEmpty) {
    EXPECT_EQ(TileDistribution(32, 32, 0, 4).batch, 1u);
    EXPECT_EQ(TileDistribution(320, 320, 0, 4).batch, 100u);  // nothing is sent
    EXPECT_EQ(TileDistribution(320, 320, 2 * TileDistribution::batchBytes, 4).batch, 4u);
}

TEST(TileDistribution, LargePicturesHaveManyBatches) {
    EXPECT_EQ(TileDistribution(8192, 4096, 0, 2).batch, 2 * TileDistribution::mostOfARank);
}

}  // namespace
}  // namespace mote::render
