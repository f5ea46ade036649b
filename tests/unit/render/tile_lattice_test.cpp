// SPDX-License-Identifier: GPL-3.0-or-later
//
// A lattice of rays through a tile: what it takes for smooth, and pictures by it against those in which each
// pixel has rays of its own.
#include "server/render/cpu/composite/tile_lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <span>

#include "server/render/cpu/composite/composite.h"
#include "server/render/cpu/resident_fields.h"
#include "server/render/layers/make_frame_plan.h"
#include "tests/support/beams.h"
#include "tests/support/memory_step.h"
#include "tests/support/view_text.h"

namespace mote::render {
namespace {

/// A beam's volume, a cell of which is some ten pixels large, and points that are put into cells by hand.
class TileLatticeTest : public testing::Test {
  protected:
    TileLatticeTest() {
        const auto step = test::MemoryStep::make(test::beam({.core = 20000, .halo = 4000, .filaments = 2000}),
                                                 {.leafCapacity = 64, .maxLevel = 5, .volumeLevel = 4});
        auto view = test::viewOf(
            "{'width': 320, 'height': 256, 'background': [0, 0, 0.3], 'camera': {'eye': [0.7, 0.5, 1.6], "
            "'target': [0, 0, 0]}, 'layers': [{'particles': {'volume': {'curve': [{'density': 0, 'opacity': "
            "0}, {'density': 1, 'opacity': 0.6}]}, 'points': {'opacity': 0.6, 'color': [1, 0, 0]}}}]}");
        plan_ = makeFramePlan({view, {{.step = step}}}, Quality::exact());
        frame_ = std::make_unique<CompositeFrame>(plan_, PixelFormat::srgb8, fields_.of(plan_),
                                                  FrameColors(plan_.points.size()));
    }

    /// Points at random: alone and many in a cell.
    TileCells somePoints(std::uint32_t seed) const {
        TileCells cells(frame_->slabs);
        std::mt19937 random(seed);
        for (int i = 0; i < 2000; ++i) {
            const std::uint32_t slab = random() % cells.slabs() / slabsApart_ * slabsApart_;
            const std::uint32_t pixel = random() % Tile::pixels;
            const float weight = random() % 2 == 0 ? 1.0F : 3.0F;
            PointCell& cell = cells.cells()[std::size_t{slab} * Tile::pixels + pixel];
            cell.weight += weight;
            cell.depth += weight * static_cast<float>(random() % 100) * 0.01F;
            cells.touched()[std::size_t{slab} * Tile::packets + pixel / Tile::packetPixels] = 1;
        }
        cells.settle();
        return cells;
    }

    std::vector<std::uint8_t> picture(std::uint8_t smooth, std::uint32_t layers) {
        frame_->smooth = smooth;
        while (frame_->points.size() < layers) frame_->points.push_back(frame_->points.front());
        frame_->points.back().color = {0.0F, 1.0F, 0.2F};
        std::vector<std::uint8_t> pixels(std::size_t{frame_->width} * frame_->height * 4);
        for (std::uint32_t row = 0; row < tilesAcross(frame_->height); ++row) {
            for (std::uint32_t column = 0; column < tilesAcross(frame_->width); ++column) {
                std::vector<TileCells> cells;
                for (std::uint32_t l = 0; l < layers; ++l)
                    cells.push_back(somePoints(row * 100 + column * 10 + l));
                compositeTile(*frame_, {column, row}, cells, nullptr, pixels.data());
            }
        }
        return pixels;
    }

    void expectAlike(std::uint32_t layers) {
        const std::uint8_t smooth = frame_->smooth;
        ASSERT_GT(smooth, 0);
        const auto own = picture(0, layers), told = picture(smooth, layers);
        double squares = 0.0;
        std::size_t far = 0, other = 0;
        for (std::size_t i = 0; i < own.size(); ++i) {
            const int off = std::abs(int{own[i]} - int{told[i]});
            squares += off * off;
            far += off > 2 ? 1 : 0;
            other += off > 0 ? 1 : 0;
        }
        const auto count = static_cast<double>(own.size());
        EXPECT_LE(squares / count, 255.0 * 255.0 / 1e5);  // 50 dB
        EXPECT_LE(static_cast<double>(far) / count, 0.001);
        EXPECT_GT(other, 0U) << "nothing was told by a lattice";
    }

    /// A lattice that was told a function of the pixel, and its rounds.
    template <class Value>
    TileLattice told(const Value& value, int& rounds) {
        return told([&](std::size_t, double x, double y) { return value(x, y); }, {}, rounds);
    }
    /// The same of a function of the border's row and the pixel, among points.
    template <class Value>
    TileLattice told(const Value& value, std::span<const TileCells> points, int& rounds) {
        frame_->smooth = 4;
        TileLattice lattice(*frame_, tile_, points);
        for (rounds = 0; !lattice.wanted().empty(); ++rounds) {
            for (const auto node : lattice.wanted()) {
                const auto place = lattice.places(std::array{node})[0] - glm::dvec2(32.0, 64.0);
                for (std::size_t row = 0; row <= lattice.lastRow(); ++row)
                    lattice.at(row, node).fill(
                        static_cast<float>(value(row, place.x / Tile::edge, place.y / Tile::edge)));
            }
            lattice.judge();
        }
        return lattice;
    }

    /// A point in the first pixel of a packet in one slab, and of another packet in another.
    std::array<TileCells, 1> twoPoints(std::uint32_t packet, std::uint32_t slab, std::uint32_t otherPacket,
                                       std::uint32_t otherSlab) const {
        TileCells cells(frame_->slabs);
        const auto add = [&](std::uint32_t p, std::uint32_t s) {
            cells.cells()[std::size_t{s} * Tile::pixels + std::size_t{p} * Tile::packetPixels] = {1.0F, 0.5F};
            cells.touched()[std::size_t{s} * Tile::packets + p] = 1;
        };
        add(packet, slab);
        add(otherPacket, otherSlab);
        cells.settle();
        return {std::move(cells)};
    }

    static constexpr Tile tile_{1, 2};
    std::uint32_t slabsApart_ = 1;  // of points
    FramePlan plan_;
    ResidentFields fields_;
    std::unique_ptr<CompositeFrame> frame_;
};

TEST_F(TileLatticeTest, AParabolaIsToldByItsFirstRays) {
    int rounds = 0;
    const auto lattice = told([](double x, double y) { return 0.2 + x * y + x * x * (1 - y); }, rounds);
    EXPECT_EQ(rounds, 1);
    for (std::uint32_t packet = 0; packet < Tile::packets; ++packet) {
        ASSERT_TRUE(lattice.smooth(packet));
        EXPECT_EQ(lattice.around(packet).step, 4U);
    }
}

TEST_F(TileLatticeTest, AnEdgeIsLeftToThePixelsRoundIt) {
    int rounds = 0;
    // In a packet at column 20; parabolas through a node on its far side are of its neighbour.
    const auto lattice = told([](double x, double) { return x < 21.5 / 32.0 ? 0.2 : 0.6; }, rounds);
    EXPECT_EQ(rounds, 3);
    for (std::uint32_t packet = 0; packet < Tile::packets; ++packet) {
        const std::uint32_t column = packet % 8;
        EXPECT_EQ(lattice.smooth(packet), column != 4 && column != 5) << column;
    }
}

TEST_F(TileLatticeTest, WhatIsBendingMoreIsToldByMoreRays) {
    const auto waves = [](double length) {
        return
            [length](double x, double y) { return 0.5 + 0.2 * std::sin(x * length) * std::cos(y * length); };
    };
    int few = 0, more = 0;
    const auto wide = told(waves(2.0), few), narrow = told(waves(8.0), more);
    EXPECT_LT(few, more);
    EXPECT_TRUE(narrow.smooth(27));
    EXPECT_LT(narrow.around(27).step, wide.around(27).step);
}

/// What is told where a packet has no points is nothing to it: whether it bends, or is not known at all.
TEST_F(TileLatticeTest, BordersCountForPacketsWithPointsBehindThem) {
    const FieldReach::Slabs reach = frame_->reach.of(tile_);
    ASSERT_GT(reach.first, 0U);
    ASSERT_GT(reach.end, reach.first + 8);
    ASSERT_LT(reach.end, frame_->slabs);
    constexpr std::uint32_t packet = 9, other = 54;  // of opposite quarters
    const auto quarter = [](std::uint32_t p) { return p / 32 * 2 + p % 8 / 4; };
    const auto expectOthersSmooth = [&](const TileLattice& lattice) {
        EXPECT_FALSE(lattice.smooth(packet));
        for (std::uint32_t p = 0; p < Tile::packets; ++p) {
            EXPECT_TRUE(lattice.smooth(p) || quarter(p) == quarter(packet)) << p;
        }
    };
    int rounds = 0;
    for (const std::uint32_t slab : {reach.first - 1, reach.first + 2, reach.end}) {
        const auto points = twoPoints(packet, slab, other, reach.first + 6);
        const TileLattice lattice(*frame_, tile_, points);
        const std::size_t row = lattice.row(slab);
        for (const std::size_t wrong : {row, row + 1}) {
            if (wrong == lattice.lastRow()) continue;  // which counts for all
            const auto unknown = [&](std::size_t at, double, double) {
                return at == wrong ? std::nan("") : 0.5;
            };
            expectOthersSmooth(told(unknown, points, rounds));
            const auto bent = [&](std::size_t at, double x, double y) {
                return at == wrong ? 0.5 + 0.1 * std::sin(40.0 * x) * std::sin(40.0 * y) : 0.5;
            };
            expectOthersSmooth(told(bent, points, rounds));
        }
    }
}

TEST_F(TileLatticeTest, PixelsAreThoseOfTheirOwnRays) {
    expectAlike(1);
}

TEST_F(TileLatticeTest, SoTheyAreWherePointsFillASlab) {
    slabsApart_ = 48;
    expectAlike(1);
}

TEST_F(TileLatticeTest, PointsOfSeveralLayersStandAmongFieldsThatAreTold) {
    expectAlike(2);
}

}  // namespace
}  // namespace mote::render
