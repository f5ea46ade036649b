// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/plot_axis.h"

#include <fmt/format.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

namespace mote::prep {
namespace {

constexpr std::size_t rowsAtOnce = std::size_t{1} << 14;

std::string unitOfColumn(Column column, const ParticleSource& source) {
    if (column == Column::weight) return source.weightUnit().empty() ? "1" : source.weightUnit();
    const auto at = static_cast<std::size_t>(column);
    if (at >= columnCount) return source.records()[at - columnCount].unit;
    return std::string(knownQuantities()[at].unit);
}

}  // namespace

std::vector<Column> columnsOf(const ParticleSource& source) {
    std::vector<Column> columns;
    for (std::size_t i = 0; i + 1 < columnCount; ++i) {
        if (source.has(static_cast<Column>(i))) columns.push_back(static_cast<Column>(i));
    }
    for (std::size_t i = 0; i < source.records().size(); ++i) columns.push_back(recordColumn(i));
    return columns;
}

std::string columnName(Column column, const ParticleSource& source) {
    const auto at = static_cast<std::size_t>(column);
    return at >= columnCount ? source.records()[at - columnCount].name
                             : std::string(knownQuantities()[at].name);
}

BeamContext contextOf(const ParticleSource& source) {
    BeamContext context;
    context.mass = source.mass();
    context.photons = source.species() == "photon";
    return context;
}

Result<PlotAxis> PlotAxis::make(std::string_view name, const ParticleSource& source) {
    const auto all = columnsOf(source);
    const auto context = contextOf(source);
    RunColumns run{{}, context.mass, context.photons, "run", " (for IMPACT files: --mass)"};
    for (const auto column : all)
        run.columns.push_back({columnName(column, source), unitOfColumn(column, source)});
    auto made = Quantity::make(name, run);
    if (!made.ok()) return Error{made.error().code, fmt::format("axis {}", name), made.error().message};
    PlotAxis axis;
    axis.quantity_ = *std::move(made);
    for (const auto column : axis.quantity_.columns()) axis.columns_.push_back(all[column]);
    return axis;
}

void PlotAxis::evaluate(const ParticleChunk& chunk, const BeamContext& context, std::span<double> out) const {
    tbb::enumerable_thread_specific<Quantity::Scratch> scratches;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, out.size(), rowsAtOnce), [&](const auto& range) {
        std::vector<std::span<const double>> parts;
        for (const auto column : columns_)
            parts.push_back(std::span(chunk[column]).subspan(range.begin(), range.size()));
        quantity_.evaluate(parts, context, scratches.local(), out.subspan(range.begin(), range.size()));
    });
}

}  // namespace mote::prep
