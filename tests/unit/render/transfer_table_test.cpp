// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/transfer_table.h"

#include <gtest/gtest.h>

#include <cmath>

#include "protocol/scene/log_density.h"
#include "protocol/scene/particles_style.h"

namespace mote::render {
namespace {

ParticlesStyle styleOf(std::vector<Curve::Knot> knots) {
    return {Curve::create(std::move(knots)).value(),
            ColorMap::standard(),
            Curve::constant(1.0),
            0.5,
            1.0,
            glm::dvec3(1.0)};
}

double tOf(std::uint32_t i) {
    return -LogDensity::fade + i * (1.0 + LogDensity::fade) / TransferTable::cells;
}

TEST(TransferTable, HoldsTheIntegralOfExtinction) {
    const auto style = styleOf({{0.2, 0.0}, {0.6, 0.5}, {1.0, 0.1}});
    const TransferTable table(style.transfer());
    ASSERT_EQ(table.ofCells().size(), TransferTable::cells);
    const double cell = (1.0 + LogDensity::fade) / TransferTable::cells;
    double summed = 0.0;
    // The midpoint rules with 200,000 steps and with eight a cell err by less than this of a sum of order 10.
    constexpr int steps = 200000;
    double integral = 0.0;
    std::uint32_t next = 0;
    for (int i = 0; i <= steps; ++i) {
        const double at = -LogDensity::fade + i * (1.0 + LogDensity::fade) / steps;
        while (next <= TransferTable::cells && tOf(next) <= at + 1e-12) {
            EXPECT_NEAR(summed, integral, 2e-4) << "t = " << tOf(next);
            if (next < TransferTable::cells) summed += cell * table.ofCells()[next].extinction;
            ++next;
        }
        const double width = (1.0 + LogDensity::fade) / steps;
        integral += style.transfer().extinction(at + 0.5 * width) * width;
    }
    EXPECT_EQ(next, TransferTable::cells + 1U);
}

TEST(TransferTable, ColorsAreWeightedByExtinction) {
    const auto style = styleOf({{0.0, 0.3}});
    const TransferTable table(style.transfer());
    const glm::dvec3 color = style.colorMap(tOf(3000));
    for (int channel = 0; channel < 3; ++channel)
        EXPECT_NEAR(table.ofCells()[3000].color[channel], color[channel], 5e-3);
}

TEST(TransferTable, CellsSayHowExtinctionChangesInThem) {
    // t = 0, where a plot of one density lies, ends a cell: a curve that begins there shows nothing of it.
    const auto style = styleOf({{0.0, 0.0}, {0.003, 0.1}});
    const TransferTable table(style.transfer());
    const auto zero = static_cast<std::size_t>(
        std::lround(LogDensity::fade / (1.0 + LogDensity::fade) * TransferTable::cells));
    EXPECT_NEAR(tOf(static_cast<std::uint32_t>(zero)), 0.0, 1e-12);
    const auto& cell = table.ofCells()[zero];
    EXPECT_NEAR(cell.extinction - 0.5 * cell.change, 0.0, 1e-2 * cell.extinction);
    EXPECT_NEAR(cell.extinction + 0.5 * cell.change,
                style.transfer().extinction(tOf(static_cast<std::uint32_t>(zero) + 1)),
                1e-2 * cell.extinction);
    EXPECT_EQ(table.ofCells()[zero - 1].extinction, 0.0);
}

TEST(TransferTable, WhatIsNotSeenHasTheColorOfWhatIsSeenBesideIt) {
    const auto extinction = [](double x) { return (x > 0.25 && x < 0.375) || x > 0.75 ? 1.0 : 0.0; };
    const auto color = [](double x) { return glm::dvec3(x < 0.5 ? 0.25 : 1.0, 0.0, x); };
    const TransferTable table(0.0, 1.0, extinction, color);
    const auto redAt = [&](double x) {
        return table.ofCells()[static_cast<std::size_t>(x * TransferTable::cells)].color.x;
    };
    for (const double x : {0.0, 0.2, 0.3, 0.45, 0.55}) EXPECT_EQ(redAt(x), 0.25) << x;
    for (const double x : {0.6, 0.7, 0.8, 0.999}) EXPECT_EQ(redAt(x), 1.0) << x;
    const TransferTable blank(
        0.0, 1.0, [](double) { return 0.0; }, color);
    EXPECT_EQ(blank.ofCells()[17].color, glm::dvec3(0.0));
}

TEST(TransferTable, KnowsWhereNothingIsSeen) {
    const TransferTable table(styleOf({{0.4, 0.0}, {0.5, 0.3}, {0.6, 0.0}}).transfer());
    EXPECT_FALSE(table.visible(-0.125F, 0.39F));
    EXPECT_FALSE(table.visible(0.61F, 1.0F));
    EXPECT_TRUE(table.visible(0.45F, 0.45F));
    EXPECT_TRUE(table.visible(-0.125F, 1.0F));
    EXPECT_TRUE(table.visible(0.2F, 0.41F));
    EXPECT_FALSE(TransferTable(styleOf({{0.0, 0.0}}).transfer()).visible(-0.125F, 1.0F));
    // Opaque at the least density: still seen while it fades towards empty space.
    EXPECT_TRUE(TransferTable(styleOf({{0.0, 0.3}}).transfer()).visible(-0.1F, -0.05F));
}

const auto white = [](double) { return glm::dvec3(1.0); };

/// The number of the first entry from one on that has extinction, told without the table's own list.
double nextByHand(const TransferTable& table, std::uint32_t entry) {
    for (; entry < TransferTable::cells + 2; ++entry)
        if (table.entries()[entry].mean() > 0.0F) return entry;
    return INFINITY;
}

void expectNextVisible(const TransferTable& table) {
    for (std::uint32_t i = 0; i < TransferTable::cells + 2; ++i)
        EXPECT_EQ(table.nextVisible()[i], nextByHand(table, i)) << i;
}

TEST(TransferTable, KnowsWhatIsNextSeen) {
    // Two bands, the second a single entry wide; beyond both ends nothing.
    expectNextVisible(TransferTable(
        0.0, 1.0,
        [](double x) {
            const double entry = x * TransferTable::cells;
            return (x > 0.25 && x < 0.5) || (entry > 3000.0 && entry < 3001.0) ? 1.0 : 0.0;
        },
        white));
}

TEST(TransferTable, SeesWhatGoesOnBeyondItsEnds) {
    const TransferTable table(
        0.0, 1.0, [](double x) { return x <= 0.0 || x >= 1.0 ? 1.0 : 0.0; }, white);
    expectNextVisible(table);
    EXPECT_EQ(table.nextVisible()[0], 0.0F);
    EXPECT_EQ(table.nextVisible()[1], TransferTable::cells + 1.0F);
}

TEST(TransferTable, FindsNothingWhereNothingIsSeen) {
    const TransferTable table(
        0.0, 1.0, [](double) { return 0.0; }, white);
    for (std::uint32_t i = 0; i < TransferTable::cells + 2; ++i) EXPECT_EQ(table.nextVisible()[i], INFINITY);
}

}  // namespace
}  // namespace mote::render
