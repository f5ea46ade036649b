// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/beam/quantity_reader.h"

#include <algorithm>

namespace mote::storage {

RunColumns runOf(const ParticleColumns& columns, const BeamContext& context) {
    RunColumns run{{}, context.mass, context.photons, "dataset", ""};
    for (const auto& column : columns.columns()) run.columns.push_back({column.name, column.unit});
    return run;
}

Result<QuantityReader> QuantityReader::make(const ParticleColumns& columns, const BeamContext& context,
                                            std::span<const std::string> names) {
    QuantityReader reader(columns, context);
    const auto run = runOf(columns, context);
    const auto need = [&](std::size_t column) {
        const auto found = std::ranges::find(reader.needed_, column);
        const auto at = static_cast<std::size_t>(found - reader.needed_.begin());
        if (found == reader.needed_.end()) reader.needed_.push_back(column);
        return at;
    };
    for (const auto& name : names) {
        auto made = Quantity::make(name, run);
        if (!made.ok()) return Error{made.error().code, name, made.error().message};
        Source source{*std::move(made), {}};
        for (const auto column : source.quantity.columns()) source.columns.push_back(need(column));
        reader.units_.push_back(source.quantity.unit());
        reader.sources_.push_back(std::move(source));
    }
    return reader;
}

void QuantityReader::read(std::uint64_t begin, std::size_t count, Scratch& scratch,
                          std::span<const std::span<double>> out) const {
    scratch.columns.resize(std::max(scratch.columns.size(), needed_.size()));
    for (std::size_t i = 0; i < needed_.size(); ++i) {
        auto& values = scratch.columns[i];
        values.resize(std::max(values.size(), count));
        columns_->read(needed_[i], begin, std::span(values).first(count));
    }
    std::vector<std::span<const double>> parts;
    for (std::size_t i = 0; i < sources_.size(); ++i) {
        parts.clear();
        for (const auto column : sources_[i].columns)
            parts.push_back(std::span(scratch.columns[column]).first(count));
        sources_[i].quantity.evaluate(parts, context_, scratch.quantity, out[i]);
    }
}

}  // namespace mote::storage
