// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/beam/quantity_reader.h"

#include <fmt/format.h>

#include <algorithm>

namespace mote::storage {
namespace {

std::string whatThereIs(const ParticleColumns& columns) {
    std::string names;
    for (const auto& column : columns.columns()) {
        names += fmt::format("{}{}", names.empty() ? "" : ", ", column.name);
    }
    return names.empty() ? "none" : names;
}

Error missing(const std::string& name, std::string_view what, const ParticleColumns& columns) {
    return {ErrorCode::notFound, name.substr(0, 64),
            fmt::format("{}; its columns are {}", what, whatThereIs(columns))};
}

}  // namespace

Result<QuantityReader> QuantityReader::make(const ParticleColumns& columns, const BeamContext& context,
                                            std::span<const std::string> names) {
    QuantityReader reader(columns, context);
    const auto need = [&](std::size_t column) {
        const auto found = std::ranges::find(reader.needed_, column);
        const auto at = static_cast<std::size_t>(found - reader.needed_.begin());
        if (found == reader.needed_.end()) reader.needed_.push_back(column);
        return at;
    };
    for (const auto& name : names) {
        Source source;
        if (const auto column = columns.find(name)) {
            source.columns.push_back(need(*column));
            reader.units_.push_back(columns.columns()[*column].unit);
            reader.sources_.push_back(std::move(source));
            continue;
        }
        source.derived = findDerivedQuantity(name);
        if (source.derived == nullptr) {
            return missing(name, "is neither a column of the dataset nor derived from one", columns);
        }
        for (const auto part : source.derived->columns) {
            const auto column = columns.find(part);
            if (!column) {
                return missing(name, fmt::format("needs {}, which the dataset does not have", part), columns);
            }
            source.columns.push_back(need(*column));
        }
        if (source.derived->needsMass && !(context.mass > 0.0)) {
            return missing(name, "needs the particles' mass, which the dataset does not know", columns);
        }
        reader.units_.emplace_back(source.derived->unit);
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
        if (sources_[i].derived != nullptr) {
            evaluate(*sources_[i].derived, parts, context_, out[i]);
        } else {
            std::ranges::copy(parts.front(), out[i].begin());
        }
    }
}

}  // namespace mote::storage
