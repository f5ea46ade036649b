// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/statistic_name.h"

#include <fmt/format.h>

#include "protocol/quantity/expression.h"
#include "protocol/quantity/known_quantity.h"
#include "protocol/quantity/statistic.h"

namespace mote::client {
ColumnUnits columnUnits(const proto::ParticlesManifest& manifest) {
    ColumnUnits units;
    for (const auto& known : knownQuantities()) units.emplace(known.name, known.unit);
    for (const auto& axis : manifest.axes()) units[axis.name()] = axis.unit();
    for (const auto& column : manifest.columns()) units[column.name()] = column.unit();
    return units;
}

std::string unitOfColumn(std::string_view column, const ColumnUnits& units) {
    if (const auto found = units.find(column); found != units.end()) return found->second;
    if (!Expression::looksLikeOne(column)) return {};
    const auto expression = Expression::parse(column);
    if (!expression.ok()) return {};
    std::vector<std::string> of;
    for (const auto& name : expression->names()) {
        const auto found = units.find(name.text);
        of.push_back(found == units.end() ? std::string() : found->second);
    }
    return expression->unit(of);
}

std::vector<std::string> columnsOf(std::string_view statistic) {
    if (const auto known = findStatistic(statistic)) return statistics()[*known].of;
    const auto parsed = parseQuantityStatistic(statistic);
    return parsed ? parsed->quantities : std::vector<std::string>();
}

std::string unitOf(std::string_view statistic, const ColumnUnits& units) {
    if (const auto known = findStatistic(statistic)) return statistics()[*known].unit;
    const auto parsed = parseQuantityStatistic(statistic);
    if (!parsed) return {};
    std::vector<std::string> of;
    for (const auto& quantity : parsed->quantities) of.push_back(unitOfColumn(quantity, units));
    return parsed->unit(of);
}

std::string withUnit(std::string_view name, std::string_view unit, bool told) {
    if (unit.empty() || (unit == "1" && !told)) return std::string(name);
    return fmt::format("{} [{}]", name, unit);
}

}  // namespace mote::client
