// SPDX-License-Identifier: GPL-3.0-or-later
//
// Cells that are sent and added are the cells that one rank would have gathered.
#include <gtest/gtest.h>

#include <random>

#include "server/render/ranks/cell_bytes.h"

namespace mote::render {
namespace {

constexpr std::uint32_t slabs = 192;

/// Weights and depths are small whole numbers: their sums are exact in any order.
void addRandomCells(std::vector<TileCells>& layers, std::mt19937_64& random, int count) {
    for (int i = 0; i < count; ++i) {
        auto& layer = layers[random() % layers.size()];
        const std::size_t cell = random() % (std::size_t{slabs} * Tile::pixels);
        layer.cells()[cell].weight += 1.0F;
        layer.cells()[cell].depth += static_cast<float>(random() % 2);
        layer.touched()[cell / Tile::packetPixels] = 1;
        if (!layer.shaded()) continue;
        layer.shades()[cell % Tile::pixels].weight += 1.0F;
        layer.shades()[cell % Tile::pixels].level += static_cast<float>(random() % 256);
    }
    for (auto& layer : layers) layer.settle();
}

void expectSame(const TileCells& one, const TileCells& other) {
    for (std::uint32_t slab = 0; slab < slabs; ++slab) {
        ASSERT_EQ(one.occupied(slab), other.occupied(slab));
        for (std::uint32_t i = 0; i < Tile::pixels; ++i) {
            ASSERT_EQ(one.slab(slab)[i].weight, other.slab(slab)[i].weight);
            ASSERT_EQ(one.slab(slab)[i].depth, other.slab(slab)[i].depth);
        }
    }
    ASSERT_EQ(one.shaded(), other.shaded());
    for (std::uint32_t i = 0; one.shaded() && i < Tile::pixels; ++i) {
        ASSERT_EQ(one.shades()[i].weight, other.shades()[i].weight);
        ASSERT_EQ(one.shades()[i].level, other.shades()[i].level);
    }
}

class CellBytesTest : public testing::TestWithParam<int> {};

TEST_P(CellBytesTest, SumsOfPartsAreTheWhole) {
    std::mt19937_64 random(7);
    std::vector<TileCells> none(3, TileCells(slabs));
    none[1] = TileCells(slabs, 0, true);
    std::vector<TileCells> whole = none, sum = none;
    for (int part = 0; part < 3; ++part) {
        std::vector<TileCells> cells = none;
        auto same = random;
        addRandomCells(cells, random, GetParam());
        addRandomCells(whole, same, GetParam());
        const auto packed = packCells(cells);
        EXPECT_LE(packed.size(), mostCellBytes(slabs, cells.size()));
        addCells(packed, sum);
    }
    for (std::size_t i = 0; i < sum.size(); ++i) {
        sum[i].settle();
        expectSame(sum[i], whole[i]);
    }
}

INSTANTIATE_TEST_SUITE_P(Points, CellBytesTest, testing::Values(0, 1, 5000, 1000000));

TEST(CellBytes, EmptyCellsOfAPacketStayAtHome) {
    std::vector<TileCells> one(1, TileCells(slabs));
    one[0].cells()[17] = {2.0F, 1.0F};
    one[0].touched()[1] = 1;
    one[0].touched()[5] = 1;  // nothing there after all
    one[0].settle();
    EXPECT_EQ(packCells(one).size(), sizeof(std::uint64_t) + 4 + sizeof(PointCell));
}

}  // namespace
}  // namespace mote::render
