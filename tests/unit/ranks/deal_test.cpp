// SPDX-License-Identifier: GPL-3.0-or-later
//
// How leaves and tiles are dealt out to ranks: nothing is lost, nothing is drawn twice, nobody has much more
// than others.
#include <gtest/gtest.h>

#include <random>

#include "server/render/plan/point_selection.h"
#include "server/render/ranks/leaf_deal.h"
#include "server/render/ranks/tile_deal.h"

namespace mote::render {
namespace {

class LeafDealTest : public testing::TestWithParam<std::tuple<std::size_t, int>> {};

TEST_P(LeafDealTest, EachLeafInViewIsOneRanks) {
    const auto [leaves, ranks] = GetParam();
    const LeafDeal deal(leaves, ranks);
    std::mt19937_64 random(leaves);
    std::vector<std::uint64_t> inView((leaves + 63) / 64);
    for (auto& word : inView) word = random();
    std::vector<std::vector<std::uint64_t>> own, ofAll;
    for (int rank = 0; rank < ranks; ++rank) {
        own.push_back(deal.own(inView, leaves, rank));
        ofAll.push_back(deal.own({}, leaves, rank));
    }
    for (std::size_t leaf = 0; leaf < leaves; ++leaf) {
        for (int rank = 0; rank < ranks; ++rank) {
            const bool mine = deal.owner(leaf) == rank;
            const auto at = static_cast<std::size_t>(rank);
            ASSERT_EQ(own[at][leaf / 64] >> (leaf % 64) & 1, mine && render::inView(inView, leaf) ? 1 : 0);
            ASSERT_EQ(ofAll[at][leaf / 64] >> (leaf % 64) & 1, mine ? 1 : 0);
        }
    }
}

TEST_P(LeafDealTest, RanksHaveNearlyAsMuch) {
    const auto [leaves, ranks] = GetParam();
    const LeafDeal deal(leaves, ranks);
    std::vector<std::size_t> counts(static_cast<std::size_t>(ranks));
    for (std::size_t leaf = 0; leaf < leaves; ++leaf) ++counts[static_cast<std::size_t>(deal.owner(leaf))];
    const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
    EXPECT_LE(*most - *least, deal.run());
    // A run is at most a 32nd of a fair share, unless it has its least length.
    EXPECT_TRUE(deal.run() == 64 || deal.run() * 32 <= leaves / static_cast<std::size_t>(ranks));
}

INSTANTIATE_TEST_SUITE_P(Sizes, LeafDealTest,
                         testing::Combine(testing::Values(1, 63, 64, 65, 1000, 123457),
                                          testing::Values(1, 2, 3, 8)));

TEST(LeafDeal, RunsAreBounded) {
    EXPECT_EQ(LeafDeal(0, 4).run(), 64u);
    EXPECT_EQ(LeafDeal(std::size_t{1} << 40, 2).run(), std::size_t{1} << 17);
}

class TileDealTest : public testing::TestWithParam<int> {};

TEST_P(TileDealTest, BatchesHoldEachTileOnce) {
    const TileDeal deal(1280, 720, TileDeal::batchBytes / 100, GetParam());
    EXPECT_EQ(deal.tiles, 40u * 23u);
    EXPECT_EQ(deal.batch, 100u);
    std::vector<int> seen(deal.tiles);
    for (std::uint32_t begin = 0; begin < deal.tiles; begin += deal.batch) {
        const std::uint32_t end = std::min(deal.tiles, begin + deal.batch);
        for (std::uint32_t rank = 0; rank < deal.ranks; ++rank) {
            std::uint32_t count = 0;
            for (auto tile = deal.firstOf(rank, begin); tile < end; tile += deal.ranks, ++count) {
                EXPECT_EQ(deal.owner(tile), rank);
                ++seen[tile];
            }
            EXPECT_EQ(deal.countOf(rank, begin, end), count);
        }
    }
    EXPECT_EQ(seen, std::vector<int>(deal.tiles, 1));
}

INSTANTIATE_TEST_SUITE_P(Ranks, TileDealTest, testing::Values(1, 2, 3, 7, 64));

TEST(TileDeal, ABatchIsNeverEmpty) {
    EXPECT_EQ(TileDeal(32, 32, 0, 4).batch, 1u);
    EXPECT_EQ(TileDeal(320, 320, 0, 4).batch, 100u);  // nothing is sent
    EXPECT_EQ(TileDeal(320, 320, 2 * TileDeal::batchBytes, 4).batch, 4u);
}

}  // namespace
}  // namespace mote::render
