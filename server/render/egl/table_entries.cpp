// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/table_entries.h"

#include <algorithm>
#include <bit>

namespace mote::render {
namespace {

constexpr std::uint32_t count = TransferTable::cells + 2;

/// How many entries it is from each to one with extinction.
std::vector<std::uint32_t> waysToExtinction(const TransferTable& table) {
    std::vector<std::uint32_t> ways(count, count);
    const auto pass = [&](std::uint32_t i, std::uint32_t before) {
        ways[i] = table.entries()[i].mean() > 0.0F ? 0 : std::min(ways[i], before + 1);
        return ways[i];
    };
    std::uint32_t way = count;
    for (std::uint32_t i = 0; i < count; ++i) way = pass(i, way);
    for (std::uint32_t i = count; i-- > 0;) way = pass(i, way);
    return ways;
}

}  // namespace

std::vector<TableEntry> tableEntries(const TransferTable& table) {
    const auto ways = waysToExtinction(table);
    std::vector<TableEntry> entries;
    entries.reserve(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto& entry = table.entries()[i];
        // Rounded to the nearest.
        const std::uint32_t bend = (std::bit_cast<std::uint32_t>(entry.bend) + 0x8000U) & 0xffff0000U;
        entries.push_back({std::bit_cast<std::uint32_t>(entry.value),
                           std::bit_cast<std::uint32_t>(entry.start), entry.color, bend | ways[i]});
    }
    return entries;
}

}  // namespace mote::render
