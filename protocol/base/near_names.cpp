// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/base/near_names.h"

#include <algorithm>
#include <cctype>
#include <vector>

namespace mote {
namespace {

constexpr std::size_t furthest = 2, mostTold = 3;

/// Letters to be changed, put in or taken out, case aside (Levenshtein 1966).
std::size_t lettersApart(std::string_view a, std::string_view b) {
    const auto same = [](char x, char y) {
        return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
    };
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t before = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t changed = before + (same(a[i - 1], b[j - 1]) ? 0 : 1);
            before = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, changed});
        }
    }
    return row.back();
}

}  // namespace

std::string nearNames(std::string_view name, std::span<const std::string_view> all) {
    constexpr std::size_t longest = 64;
    std::vector<std::pair<std::size_t, std::string_view>> near;
    for (const auto one : all) {
        if (name.empty() || name.size() > longest || one.size() > longest) continue;
        if (std::ranges::count(near, one, [](const auto& told) { return told.second; }) > 0) continue;
        const auto apart = lettersApart(name, one);
        const bool begins =
            std::min(name.size(), one.size()) > 1 && (one.starts_with(name) || name.starts_with(one));
        if (apart > std::min(furthest, std::max(name.size(), one.size()) / 2) && !begins) continue;
        near.emplace_back(apart, one);
    }
    std::ranges::stable_sort(near, {}, [](const auto& one) { return one.first; });
    std::string told;
    for (std::size_t i = 0; i < std::min(near.size(), mostTold); ++i)
        told += (i == 0 ? "; near it: " : ", ") + std::string(near[i].second);
    return told;
}

}  // namespace mote
