// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/kept_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace mote::prep {
namespace {

KeptColumn columnOf(const PlotAxis& axis, const ParticleSource& source) {
    const bool weight = axis.name() == "weight";
    return {axis.name(), weight ? source.weightUnit() : axis.unit(), axis};
}

Result<KeptColumns> allColumns(const ParticleSource& source) {
    KeptColumns kept;
    for (const auto column : columnsOf(source)) {
        // Those of a dataset were asked for once.
        if (isRecord(column) && source.format() != "mote") continue;
        MOTE_ASSIGN_OR_RETURN(const auto axis, PlotAxis::make(columnName(column, source), source));
        kept.columns.push_back(columnOf(axis, source));
    }
    kept.ids = source.has(Column::id);
    return kept;
}

Status addColumn(const std::string& name, const ParticleSource& source, KeptColumns& kept) {
    const bool twice =
        name == "id" ? kept.ids : std::ranges::count(kept.columns, name, &KeptColumn::name) > 0;
    if (twice)
        return Error{ErrorCode::invalidArgument, "columns", fmt::format("\"{}\" is given twice", name)};
    if (name == "id") {
        kept.ids = source.has(Column::id);
        if (kept.ids) return success();
        return Error{ErrorCode::notFound, "columns", "the run has no column \"id\""};
    }
    const auto axis = PlotAxis::make(name, source);
    if (!axis.ok()) {
        return Error{axis.error().code, "columns",
                     fmt::format("\"{}\" {}", name.substr(0, 64), axis.error().message)};
    }
    kept.columns.push_back(columnOf(*axis, source));
    return success();
}

}  // namespace

Result<KeptColumns> keptColumns(const google::protobuf::RepeatedPtrField<std::string>& names,
                                const ParticleSource& source, bool marked) {
    if (names.size() == 1 && names[0] == "none") return KeptColumns();
    KeptColumns kept;
    if (names.empty()) {
        MOTE_ASSIGN_OR_RETURN(kept, allColumns(source));
    }
    for (const auto& name : names) {
        if (name != "lost" || !marked) MOTE_RETURN_IF_ERROR(addColumn(name, source, kept));
    }
    if (marked) kept.columns.push_back({"lost", "1", std::nullopt});
    return kept;
}

std::vector<Column> KeptColumns::sources() const {
    std::set<Column> all;
    for (const auto& column : columns) {
        const auto own = column.sources();
        all.insert(own.begin(), own.end());
    }
    return {all.begin(), all.end()};
}

void KeptColumns::describe(const ParticleSource& source, proto::ParticlesManifest& manifest) const {
    for (const auto& column : columns) {
        auto& entry = *manifest.add_columns();
        entry.set_name(column.name);
        entry.set_unit(column.unit);
        // Nothing yet: the first step's range is taken as it is.
        entry.set_min(0.0);
        entry.set_max(-1.0);
    }
    manifest.set_ids(ids);
    manifest.set_mass(source.mass());
    manifest.set_species(source.species());
    manifest.set_particle_charge(source.particleCharge());
    manifest.set_weight_unit(source.weightUnit());
}

void evaluateColumn(const KeptColumn& column, const ParticleChunk& chunk, const BeamContext& context,
                    std::span<double> out) {
    if (column.axis) return column.axis->evaluate(chunk, context, out);
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = i < chunk.lost.size() && chunk.lost[i] != 0 ? 1.0 : 0.0;
}

}  // namespace mote::prep
