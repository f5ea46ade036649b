// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/kept_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace mote::prep {
namespace {

constexpr std::array<std::string_view, 7> coordinates{"x", "y", "z", "t", "px", "py", "pz"};

Result<KeptColumns> allColumns(const ParticleSource& source) {
    KeptColumns kept;
    for (std::size_t i = 0; i < coordinates.size(); ++i) {
        if (!source.has(static_cast<Column>(i))) continue;
        MOTE_ASSIGN_OR_RETURN(auto axis, findAxis(coordinates[i]));
        kept.columns.push_back({std::string(axis.name), std::string(axis.unit), {axis}, false});
    }
    if (source.has(Column::weight)) kept.columns.push_back({"weight", source.weightUnit(), {}, false});
    kept.ids = source.has(Column::id);
    return kept;
}

Status addColumn(const std::string& name, const ParticleSource& source, KeptColumns& kept) {
    const auto absent = [&] {
        return Error{ErrorCode::notFound, "columns", fmt::format("the run has no column \"{}\"", name)};
    };
    const bool twice =
        name == "id" ? kept.ids : std::ranges::count(kept.columns, name, &KeptColumn::name) > 0;
    if (twice)
        return Error{ErrorCode::invalidArgument, "columns", fmt::format("\"{}\" is given twice", name)};
    if (name == "id") {
        kept.ids = source.has(Column::id);
        return kept.ids ? success() : Status(absent());
    }
    if (name == "weight") {
        if (!source.has(Column::weight)) return absent();
        kept.columns.push_back({"weight", source.weightUnit(), {}, false});
        return success();
    }
    auto axis = findAxis(name);
    if (!axis.ok()) return Error{ErrorCode::invalidArgument, "columns", axis.error().message};
    MOTE_RETURN_IF_ERROR(checkAxis(*axis, source));
    kept.columns.push_back({std::string(axis->name), std::string(axis->unit), {*axis}, false});
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
    if (marked) kept.columns.push_back({"lost", "1", {}, true});
    return kept;
}

void evaluateColumn(const KeptColumn& column, const ParticleChunk& chunk, const AxisContext& context,
                    std::span<double> out) {
    if (!column.axis.empty()) return evaluateAxis(column.axis.front(), chunk, context, out);
    if (column.lost) {
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = i < chunk.lost.size() && chunk.lost[i] != 0 ? 1.0 : 0.0;
        return;
    }
    std::copy_n(chunk[Column::weight].begin(), out.size(), out.begin());
}

}  // namespace mote::prep
