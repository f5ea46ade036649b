// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/quantities.h"

#include <algorithm>
#include <cmath>

#include "protocol/scene/derived_quantity.h"

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
    const std::vector<Quantity> columns = quantities;
    for (const auto& derived : derivedQuantities()) {
        const bool made = std::ranges::all_of(
            derived.columns, [&](std::string_view name) { return findQuantity(columns, name) != nullptr; });
        const bool known = findQuantity(columns, derived.name) != nullptr;
        if (made && !known && (!derived.needsMass || manifest.mass() > 0.0))
            quantities.push_back({std::string(derived.name), std::string(derived.unit)});
    }
    return quantities;
}

const Quantity* findQuantity(const std::vector<Quantity>& quantities, std::string_view name) {
    const auto found = std::ranges::find(quantities, name, &Quantity::name);
    return found == quantities.end() ? nullptr : &*found;
}

}  // namespace mote::client
