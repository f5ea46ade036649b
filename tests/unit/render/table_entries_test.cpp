// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/table_entries.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

namespace mote::render {
namespace {

/// Extinction rises from 0 at 1/2 to 1 at 3/4 and is nothing elsewhere.
TransferTable someTable() {
    return TransferTable(
        0.0, 1.0, [](double x) { return x < 0.5 || x > 0.75 ? 0.0 : 4.0 * x - 2.0; },
        [](double) { return glm::dvec3(0.25, 0.5, 1.0); });
}

float bendIn(const TableEntry& entry) {
    return std::bit_cast<float>(entry[3] & 0xffff0000U);
}

TEST(TableEntries, SayWhatTheTableDoes) {
    const TransferTable table = someTable();
    const auto entries = tableEntries(table);
    ASSERT_EQ(entries.size(), TransferTable::cells + 2U);
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const auto& expected = table.entries()[i];
        EXPECT_EQ(std::bit_cast<float>(entries[i][0]), expected.value) << i;
        EXPECT_EQ(std::bit_cast<float>(entries[i][1]), expected.start) << i;
        EXPECT_EQ(entries[i][2], expected.color) << i;
        // Eight bits of it are kept.
        EXPECT_NEAR(bendIn(entries[i]), expected.bend, std::abs(expected.bend) / 256.0) << i;
    }
}

TEST(TableEntries, SayHowFarItIsToWhatIsSeen) {
    const auto entries = tableEntries(someTable());
    const auto way = [&](std::size_t i) { return entries[i][3] & 0xffffU; };
    constexpr std::size_t first = 1 + TransferTable::cells / 2, last = 1 + 3 * TransferTable::cells / 4;
    EXPECT_EQ(way(first), 0U);
    EXPECT_EQ(way(last), 0U);
    EXPECT_EQ(way(0), first);
    EXPECT_EQ(way(first - 100), 100U);
    EXPECT_EQ(way(last + 100), 100U);
    EXPECT_EQ(way(entries.size() - 1), entries.size() - 1 - last);
}

TEST(TableEntries, NothingIsFartherThanTheTableIsLong) {
    const auto entries = tableEntries(TransferTable(
        0.0, 1.0, [](double) { return 0.0; }, [](double) { return glm::dvec3(1.0); }));
    for (const auto& entry : entries) EXPECT_EQ(entry[3], entries.size());
}

}  // namespace
}  // namespace mote::render
