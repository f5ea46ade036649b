// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/quantities.h"

#include <algorithm>
#include <cmath>

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

}  // namespace mote::client
