// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/volume_table.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mote::render {
namespace {

const auto white = [](double) { return glm::dvec3(1.0); };

/// The number of the first entry from one on that has extinction, told without the table's own list.
double nextByHand(const VolumeTable& table, std::uint32_t entry) {
    for (; entry < VolumeTable::cells + 2; ++entry)
        if (table.entries()[entry].mean() > 0.0F) return entry;
    return INFINITY;
}

void expectNextVisible(const VolumeTable& table) {
    for (std::uint32_t i = 0; i < VolumeTable::cells + 2; ++i)
        EXPECT_EQ(table.nextVisible()[i], nextByHand(table, i)) << i;
}

TEST(VolumeTable, KnowsWhatIsNextSeen) {
    // Two bands, the second a single entry wide; beyond both ends nothing.
    expectNextVisible(VolumeTable(
        0.0, 1.0,
        [](double x) {
            const double entry = x * VolumeTable::cells;
            return (x > 0.25 && x < 0.5) || (entry > 3000.0 && entry < 3001.0) ? 1.0 : 0.0;
        },
        white));
}

TEST(VolumeTable, SeesWhatGoesOnBeyondItsEnds) {
    const VolumeTable table(
        0.0, 1.0, [](double x) { return x <= 0.0 || x >= 1.0 ? 1.0 : 0.0; }, white);
    expectNextVisible(table);
    EXPECT_EQ(table.nextVisible()[0], 0.0F);
    EXPECT_EQ(table.nextVisible()[1], VolumeTable::cells + 1.0F);
}

TEST(VolumeTable, FindsNothingWhereNothingIsSeen) {
    const VolumeTable table(
        0.0, 1.0, [](double) { return 0.0; }, white);
    for (std::uint32_t i = 0; i < VolumeTable::cells + 2; ++i) EXPECT_EQ(table.nextVisible()[i], INFINITY);
}

}  // namespace
}  // namespace mote::render
