// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where DarkCells says that nothing shows, cell by cell, against the corners of each cell.
#include "server/render/cpu/composite/dark_cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>

#include "server/render/plan/seen_fields.h"

namespace mote::render {
namespace {

constexpr std::uint32_t edge = GridBricks::edge, side = GridBricks::samples;

/// Bricks of 2 x 2 x 2, the last of them not corrected: values of a smooth hill with noise, darker towards
/// the first, which is all dark.
std::shared_ptr<GridField> hill() {
    auto field = std::make_shared<GridField>();
    field->range = {-100.0, 100.0};
    field->coarse.size = glm::uvec3(2);
    field->coarse.values.assign(8 + 4, 60000);
    field->coarse.normals.assign(8 + 4, 0);
    auto bricks = std::make_shared<GridBricks>();
    bricks->size = glm::uvec3(16);
    bricks->count = glm::uvec3(2);
    bricks->numbers = {0, 1, 2, 3, 4, 5, 6, GridBricks::none};
    std::mt19937 random(5);
    for (std::uint32_t brick = 0; brick < 7; ++brick) {
        for (std::uint32_t i = 0; i < GridBricks::volume; ++i) {
            const std::uint32_t x = i % side, y = i / side % side;
            const std::uint32_t code = brick * 4000 + x * y * 300 + random() % 3000;
            bricks->values.push_back(static_cast<std::uint16_t>(brick == 0 ? 1000 : code));
        }
    }
    bricks->normals.resize(bricks->values.size());
    field->bricks = std::move(bricks);
    return field;
}

/// Nothing shows below -20 and between 0 and 40.
TransferFunction twoSheets() {
    const auto opacity =
        Curve::create({{-20.0, 0.0}, {-10.0, 0.5}, {0.0, 0.0}, {40.0, 0.0}, {60.0, 0.5}}, -100.0, 100.0);
    TransferFunction transfer{.opacity = opacity.value(), .opacityLength = 0.1};
    transfer.span = {-100.0, 100.0};
    return transfer;
}

class DarkCellsTest : public testing::Test {
  protected:
    bool shows(std::uint32_t brick, std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
        CodeRange range;
        for (std::uint32_t i = 0; i < 8; ++i) {
            const std::uint32_t at = ((z + (i >> 2U)) * side + y + (i >> 1U & 1U)) * side + x + (i & 1U);
            range.add(field_->bricks->values[brick * GridBricks::volume + at]);
        }
        return shows(field_->valueOf(range.low), field_->valueOf(range.high));
    }
    std::uint32_t steps(std::uint32_t brick, std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
        return dark_.rows()[brick * DarkCells::rowsOfBrick + z * edge + y] >> (4 * x) & 15U;
    }

    std::shared_ptr<GridField> field_ = hill();
    TransferFunction transfer_ = twoSheets();
    TransferTable table_{transfer_};
    VisibleBlocks blocks_{gridRanges({.grid = field_}), table_};
    DarkCells dark_{*field_, table_, blocks_};

  private:
    /// Whether any of its entries does, a hair of one inward.
    bool shows(double low, double high) const {
        const auto place = [&](double value) {
            return 1.0 + (value - table_.low()) / (table_.high() - table_.low()) * TransferTable::cells;
        };
        const auto first = static_cast<std::size_t>(place(low) + 0.01);
        const auto last = static_cast<std::size_t>(place(high) - 0.01);
        return table_.nextVisible()[first] <= static_cast<float>(last);
    }
};

TEST_F(DarkCellsTest, TellsTheStepsToTheNearestCellThatShows) {
    std::size_t lit = 0, dark = 0, asked = 0;
    for (std::uint32_t brick = 1; brick < 7; ++brick) {
        if (dark_.places()[brick] < 0) continue;
        asked += std::size_t{edge} * edge * edge;
        for (std::uint32_t i = 0; i < edge * edge * edge; ++i) {
            const std::uint32_t x = i % edge, y = i / edge % edge, z = i / edge / edge;
            std::uint32_t nearest = edge;
            for (std::uint32_t j = 0; j < edge * edge * edge; ++j) {
                const std::uint32_t u = j % edge, v = j / edge % edge, w = j / edge / edge;
                if (steps(brick, u, v, w) != 0) continue;
                const auto away = [](std::uint32_t a, std::uint32_t b) { return a > b ? a - b : b - a; };
                nearest = std::min(nearest, std::max({away(x, u), away(y, v), away(z, w)}));
            }
            EXPECT_EQ(steps(brick, x, y, z), nearest);
            if (shows(brick, x, y, z)) {
                EXPECT_EQ(nearest, 0U) << brick << ": " << x << ' ' << y << ' ' << z;
                ++lit;
            } else if (nearest > 0) {
                ++dark;
            }
        }
    }
    // Nearly all that show nothing are known to.
    EXPECT_GT(lit, 300U);
    EXPECT_GT(dark, (asked - lit) * 9 / 10);
    EXPECT_GT(dark, 300U);
}

TEST_F(DarkCellsTest, LeapsOverBlocksThatShowNothing) {
    EXPECT_EQ(dark_.places()[0], DarkCells::unknown - 1);
    EXPECT_EQ(dark_.places()[3], 3);
    EXPECT_EQ(dark_.places()[7], DarkCells::unknown);
}

}  // namespace
}  // namespace mote::render
