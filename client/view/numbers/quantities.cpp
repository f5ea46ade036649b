// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/quantities.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>

#include "client/shared/numbers.h"
#include "protocol/quantity/manifest_columns.h"

namespace mote::client {
namespace {

std::optional<Interval> extentOf(const proto::ColumnEntry& column) {
    const bool there =
        std::isfinite(column.min()) && std::isfinite(column.max()) && column.min() < column.max();
    if (!there) return std::nullopt;
    return Interval{column.min(), column.max()};
}

}  // namespace

std::vector<Quantity> quantitiesOf(const proto::ParticlesManifest& manifest) {
    std::vector<Quantity> quantities;
    for (const auto& column : manifest.columns())
        quantities.push_back({column.name(), column.unit(), extentOf(column)});
    const auto run = mote::columnsOf(manifest);
    for (const auto& known : knownQuantities()) {
        const auto name = std::string(known.name);
        if (findQuantity(quantities, name) == nullptr && mote::Quantity::make(name, run).ok())
            quantities.push_back({name, std::string(known.unit)});
    }
    return quantities;
}

const Quantity* findQuantity(const std::vector<Quantity>& quantities, std::string_view name) {
    const auto found = std::ranges::find(quantities, name, &Quantity::name);
    return found == quantities.end() ? nullptr : &*found;
}

namespace {

constexpr std::array<std::string_view, 21> usual{
    "n_particle",   "charge",       "mean_energy",   "sigma_energy", "sigma_x",       "sigma_y",
    "sigma_z",      "sigma_px",     "sigma_py",      "norm_emit_x",  "norm_emit_y",   "norm_emit_z",
    "norm_emit_4d", "twiss_beta_x", "twiss_alpha_x", "twiss_beta_y", "twiss_alpha_y", "halo_h_x",
    "halo_h_y",     "halo_H_x",     "halo_H_y"};

std::string valueOf(const std::optional<StepStatistics>& statistics, const std::string& name,
                    const ColumnUnits& units) {
    if (!statistics) return {};
    const auto found = std::ranges::find(statistics->names, name);
    if (found == statistics->names.end()) return {};
    return numberText(statistics->values[static_cast<std::size_t>(found - statistics->names.begin())],
                      unitOf(name, units));
}

}  // namespace

std::string numberText(double value, std::string_view unit) {
    const auto scaled = scaledUnit(value, unit);
    auto text = shortNumber(value, scaled);
    if (text.ends_with('.')) text.pop_back();
    return text == "-" || scaled.name.empty() ? text : fmt::format("{} {}", text, scaled.name);
}

std::vector<StatisticRow> statisticRows(const std::optional<StepStatistics>& whole,
                                        const std::optional<StepStatistics>& selected,
                                        const ColumnUnits& units, bool all) {
    std::vector<std::string> names;
    for (const auto* each : {&whole, &selected}) {
        if (!*each) continue;
        for (const auto& name : (*each)->names) {
            const bool looked = all || std::ranges::find(usual, name) != usual.end();
            if (looked && std::ranges::find(names, name) == names.end()) names.push_back(name);
        }
    }
    std::vector<StatisticRow> rows;
    for (const auto& name : names)
        rows.push_back({name, valueOf(whole, name, units), valueOf(selected, name, units)});
    return rows;
}

std::vector<double> seriesOf(const proto::ParticlesManifest& manifest, const std::string& statistic) {
    const auto found = std::ranges::find(manifest.statistic_names(), statistic);
    if (found == manifest.statistic_names().end()) return {};
    const int index = static_cast<int>(found - manifest.statistic_names().begin());
    std::vector<double> values;
    for (const auto& step : manifest.steps()) {
        if (step.statistics_size() != manifest.statistic_names_size()) return {};
        values.push_back(step.statistics(index));
    }
    return values;
}

}  // namespace mote::client
