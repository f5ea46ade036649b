// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/numbers/point_statistics.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "storage/numbers/row_walk.h"
#include "storage/numbers/scan.h"

namespace mote::storage {
namespace {

/// The values of each group of a walk. Nothing where `cancelled` says so.
std::optional<std::vector<std::vector<double>>> valuesOf(const RowWalk& walk, const BeamFacts& facts,
                                                         Passes wanted,
                                                         const std::function<bool()>& cancelled) {
    const auto threads = RowWalk::threads();
    const auto groups = walk.groups();
    std::vector<std::vector<BeamMoments>> moments(threads,
                                                  std::vector<BeamMoments>(groups, BeamMoments(facts.mass)));
    if (!walk.walk(cancelled, [&](std::size_t thread, std::uint32_t group, const BeamRows& rows) {
            moments[thread][group].add(rows);
        }))
        return std::nullopt;
    std::vector<BeamMoments::Sums> totals;
    std::vector<BeamPercentiles> percentiles;
    for (std::uint32_t group = 0; group < groups; ++group) {
        for (std::size_t thread = 1; thread < threads; ++thread)
            moments[0][group].merge(moments[thread][group].blocks());
        totals.push_back(moments[0][group].total());
        percentiles.emplace_back(totals.back());
    }
    moments.clear();
    const auto needsPass = [](const BeamPercentiles& one) { return one.needsPass(); };
    while (wanted == Passes::percentilesToo && std::ranges::any_of(percentiles, needsPass)) {
        std::vector<std::vector<BeamPercentiles::Gathered>> passes(
            threads, std::vector<BeamPercentiles::Gathered>(groups));
        if (!walk.walk(cancelled, [&](std::size_t thread, std::uint32_t group, const BeamRows& rows) {
                if (percentiles[group].needsPass()) percentiles[group].add(rows, passes[thread][group]);
            }))
            return std::nullopt;
        for (std::uint32_t group = 0; group < groups; ++group) {
            if (!percentiles[group].needsPass()) continue;
            for (std::size_t thread = 1; thread < threads; ++thread)
                passes[0][group].merge(passes[thread][group]);
            percentiles[group].finishPass(std::move(passes[0][group]));
        }
    }
    std::vector<std::vector<double>> values;
    for (std::uint32_t group = 0; group < groups; ++group)
        values.push_back(beamValues(totals[group], percentiles[group], facts));
    return values;
}

/// One of them in each group: the quantities take the places of x and y. Nothing where `cancelled` says so.
Result<std::optional<std::vector<double>>> furtherOf(const QuantityStatistic& statistic,
                                                     const StepNumbers& step, const PointMask* chosen,
                                                     const BinAxis* groups,
                                                     const std::function<bool()>& cancelled) {
    MOTE_ASSIGN_OR_RETURN(const auto reader,
                          QuantityReader::make(*step.columns, step.context, statistic.quantities));
    const auto all =
        valuesOf(RowWalk(*step.columns, chosen, groups, &reader), {}, Passes::momentsAlone, cancelled);
    if (!all) return std::optional<std::vector<double>>();
    const auto place = statistic.quantities.size() == 2 ? "cov_x__y" : fmt::format("{}_x", statistic.kind);
    std::vector<double> values;
    for (const auto& group : *all) values.push_back(group[*findStatistic(place)]);
    return std::optional(std::move(values));
}

/// Adds them to the values of each group.
Status addFurther(FurtherStatistics further, const StepNumbers& step, const PointMask* chosen,
                  const BinAxis* groups, const std::function<bool()>& cancelled,
                  std::span<std::vector<double>> to) {
    for (const auto& statistic : further) {
        MOTE_ASSIGN_OR_RETURN(const auto values, furtherOf(statistic, step, chosen, groups, cancelled));
        if (!values) return wasCancelled();
        for (std::size_t i = 0; i < to.size(); ++i) to[i].push_back((*values)[i]);
    }
    return success();
}

/// The least and the greatest finite value of the chosen points. Nothing where `cancelled` says so.
std::optional<std::pair<double, double>> rangeOf(const QuantityReader& reader, std::uint64_t points,
                                                 const PointMask* chosen,
                                                 const std::function<bool()>& cancelled) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    std::vector<std::pair<double, double>> ranges(blockCount(points), {infinite, -infinite});
    const bool whole = forBlocks(ranges.size(), cancelled, [&](std::uint64_t block) {
        const auto part = pointsOfBlock(block, points);
        std::vector<double> values(part.count);
        QuantityReader::Scratch scratch;
        const std::array out{std::span(values)};
        reader.read(part.begin, part.count, scratch, out);
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (!std::isfinite(values[i]) || (chosen != nullptr && !chosen->chosen(part.begin + i))) continue;
            ranges[block].first = std::min(ranges[block].first, values[i]);
            ranges[block].second = std::max(ranges[block].second, values[i]);
        }
    });
    if (!whole) return std::nullopt;
    std::pair all{infinite, -infinite};
    for (const auto& [low, high] : ranges) all = {std::min(all.first, low), std::max(all.second, high)};
    return widened(all.first, all.second);
}

}  // namespace

Result<PointStatistics> pointStatistics(const StepNumbers& step, const BeamFacts& facts,
                                        const PointMask* chosen, const std::optional<SlicesWanted>& slices,
                                        Passes passes, const std::function<bool()>& cancelled,
                                        FurtherStatistics further) {
    const auto& columns = *step.columns;
    PointStatistics found;
    auto all = valuesOf(RowWalk(columns, chosen, nullptr), facts, passes, cancelled);
    if (!all) return wasCancelled();
    MOTE_RETURN_IF_ERROR(addFurther(further, step, chosen, nullptr, cancelled, *all));
    found.values = std::move(all->front());
    if (slices) {
        const auto reader = QuantityReader::make(columns, step.context, std::span(&slices->column, 1));
        if (!reader.ok()) {
            const auto& error = reader.error();  // at the name
            return Error{error.code, "slices", fmt::format("\"{}\" {}", error.where, error.message)};
        }
        const auto range = rangeOf(*reader, columns.pointCount(), chosen, cancelled);
        if (!range) return wasCancelled();
        MOTE_ASSIGN_OR_RETURN(
            const auto bins, BinAxis::make(step, slices->column, slices->count, range->first, range->second));
        BeamFacts ofSlice = facts;
        ofSlice.lost = 0;
        auto parts = valuesOf(RowWalk(columns, chosen, &bins), ofSlice, passes, cancelled);
        if (!parts) return wasCancelled();
        MOTE_RETURN_IF_ERROR(addFurther(further, step, chosen, &bins, cancelled, *parts));
        found.edges = bins.edges();
        found.slices = *std::move(parts);
    }
    columns.check();
    return found;
}

}  // namespace mote::storage
