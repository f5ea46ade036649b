// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/statistic_name.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace mote::client {
namespace {

using Pair = std::pair<std::string_view, std::string_view>;

/// What every run may have: coordinates, and what is derived from them.
constexpr std::array<Pair, 16> ownUnits{{{"x", "m"},
                                         {"y", "m"},
                                         {"z", "m"},
                                         {"t", "s"},
                                         {"px", "eV/c"},
                                         {"py", "eV/c"},
                                         {"pz", "eV/c"},
                                         {"r", "m"},
                                         {"theta", "rad"},
                                         {"xp", "rad"},
                                         {"yp", "rad"},
                                         {"pr", "eV/c"},
                                         {"p", "eV/c"},
                                         {"delta", "1"},
                                         {"gamma", "1"},
                                         {"energy", "eV"}}};

/// Statistics in the unit of their one column, whose name may hold anything.
constexpr std::array<std::string_view, 4> ofOneColumn{"mean_", "sigma_", "min_", "max_"};
constexpr std::string_view covariance = "cov_", between = "__";

/// Units of those whose name says no more than a plane.
constexpr std::array<Pair, 9> planeUnits{{{"norm_emit_4d", "m^2"},
                                          {"emit_4d", "m^2"},
                                          {"twiss_beta", "m"},
                                          {"twiss_gamma", "1/m"},
                                          {"twiss_alpha", "1"},
                                          {"twiss_etap", "1"},
                                          {"twiss_eta", "m"},
                                          {"halo_", "1"},
                                          {"emit", "m"}}};

/// What follows the prefix; empty where it has another.
std::string_view after(std::string_view prefix, std::string_view text) {
    return text.starts_with(prefix) ? text.substr(prefix.size()) : std::string_view();
}

/// The column of "mean_x"; empty where it is another statistic.
std::string_view oneColumn(std::string_view statistic) {
    for (const auto prefix : ofOneColumn) {
        if (const auto column = after(prefix, statistic); !column.empty()) return column;
    }
    return {};
}

Pair twoColumns(std::string_view statistic) {
    const auto rest = after(covariance, statistic);
    const auto at = rest.find(between);
    if (at == std::string_view::npos) return {};
    return {rest.substr(0, at), rest.substr(at + between.size())};
}

std::string unitOfColumn(std::string_view column, const ColumnUnits& units) {
    const auto found = units.find(column);
    return found == units.end() ? std::string() : found->second;
}

std::string product(const std::string& first, const std::string& second) {
    if (first.empty() || second.empty()) return {};
    if (first == "1") return second;
    if (second == "1") return first;
    if (first != second) return first + " " + second;
    return first.find('/') == std::string::npos ? first + "^2" : "(" + first + ")^2";
}

}  // namespace

ColumnUnits columnUnits(const proto::ParticlesManifest& manifest) {
    ColumnUnits units(ownUnits.begin(), ownUnits.end());
    for (const auto& axis : manifest.axes()) units[axis.name()] = axis.unit();
    for (const auto& column : manifest.columns()) units[column.name()] = column.unit();
    return units;
}

std::vector<std::string> columnsOf(std::string_view statistic, const ColumnUnits& units) {
    if (const auto column = oneColumn(statistic); !column.empty()) return {std::string(column)};
    if (const auto [first, second] = twoColumns(statistic); !first.empty())
        return {std::string(first), std::string(second)};
    std::vector<std::string> columns;
    while (!statistic.empty()) {
        const auto word = statistic.substr(0, statistic.find('_'));
        if (word == "4d") columns.insert(columns.end(), {"x", "y"});
        // "beta" and "gamma" of twiss_gamma_x are no columns.
        const bool last = word.size() == statistic.size();
        if (last && units.contains(word)) columns.emplace_back(word);
        if (!last && word.size() == 1 && units.contains(word)) columns.emplace_back(word);
        statistic.remove_prefix(std::min(statistic.size(), word.size() + 1));
    }
    return columns;
}

std::string unitOf(std::string_view statistic, const ColumnUnits& units) {
    if (const auto column = oneColumn(statistic); !column.empty()) return unitOfColumn(column, units);
    if (const auto [first, second] = twoColumns(statistic); !first.empty())
        return product(unitOfColumn(first, units), unitOfColumn(second, units));
    if (statistic.starts_with("n_")) return "1";
    if (statistic == "charge") return "C";
    for (const auto& [part, unit] : planeUnits) {
        if (statistic.find(part) != std::string_view::npos) return std::string(unit);
    }
    return {};
}

std::string withUnit(std::string_view name, std::string_view unit, bool told) {
    if (unit.empty() || (unit == "1" && !told)) return std::string(name);
    return fmt::format("{} [{}]", name, unit);
}

}  // namespace mote::client
