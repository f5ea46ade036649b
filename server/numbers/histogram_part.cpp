// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/numbers/query_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "protocol/quantity/quantity.h"
#include "server/numbers/coarse_notes.h"
#include "storage/numbers/bin_axis.h"

namespace mote::server {
namespace {

/// What no column says: the scaled log density of a point's leaf.
constexpr std::string_view leafDensity = "leaf_density";

/// An error at a column's name.
Error atColumn(const Error& error, std::size_t axis) {
    if (error.code != ErrorCode::notFound) return error;
    return {error.code, fmt::format("axes[{}].column", axis),
            fmt::format("\"{}\" {}", error.where, error.message)};
}

Result<HistogramPart::Axis> parseAxis(const proto::HistogramQuery::Axis& message) {
    HistogramPart::Axis axis{{}, message.has_bins() ? message.bins() : 100, std::nullopt};
    MOTE_ASSIGN_OR_RETURN(axis.column, checkColumnName(message.column(), "column"));
    if (axis.bins < 1 || axis.bins > storage::HistogramAxis::mostBins) {
        return invalid("bins",
                       fmt::format("must be 1 to {}, not {}", storage::HistogramAxis::mostBins, axis.bins));
    }
    if (message.range().empty()) return axis;
    if (message.range_size() != 2 || !std::isfinite(message.range(1) - message.range(0)) ||
        !(message.range(0) < message.range(1)))
        return invalid("range", "two finite numbers are needed, the first below the second");
    axis.range = {message.range(0), message.range(1)};
    return axis;
}

}  // namespace

Result<std::unique_ptr<HistogramPart>> HistogramPart::make(const proto::HistogramQuery& query) {
    if (query.axes_size() < 1 || query.axes_size() > 2)
        return invalid("axes", fmt::format("a histogram has one axis or two, not {}", query.axes_size()));
    std::vector<HistogramPart::Axis> axes;
    for (int i = 0; i < query.axes_size(); ++i) {
        auto axis = parseAxis(query.axes(i));
        MOTE_RETURN_IF_ERROR(axis, fmt::format("axes[{}]", i));
        axes.push_back(*std::move(axis));
    }
    return std::make_unique<HistogramPart>(std::move(axes), query.unweighted());
}

Status HistogramPart::answer(const StepQuestion& question, QueryAnswer& answer) {
    MOTE_ASSIGN_OR_RETURN(const auto histogram, count(question, answer.message));
    auto& message = *answer.message.mutable_histogram();
    for (const auto& edges : histogram.edges)
        message.add_axes()->mutable_values()->Add(edges.begin(), edges.end());
    message.set_particles(histogram.particles);
    message.set_outside(histogram.outside);
    const auto bytes = histogram.counts.size() * sizeof(double);
    MOTE_ASSIGN_OR_RETURN(answer.memory, question.take(bytes));
    answer.payload.resize(bytes);
    std::memcpy(answer.payload.data(), histogram.counts.data(), bytes);
    return success();
}

/// A column of that name goes before it.
std::optional<Result<storage::Histogram>> HistogramPart::countLeaves(const StepQuestion& question) const {
    const bool wanted = axes_.size() == 1 && axes_.front().column == leafDensity && unweighted_;
    const auto& columns = question.manifest().columns();
    const auto isColumn = [](const auto& column) { return column.name() == leafDensity; };
    if (!wanted || std::ranges::any_of(columns, isColumn)) return std::nullopt;
    const auto step = question.points();
    if (!step.ok()) return step.error();
    const auto chosen = question.chosen();
    if (!chosen.ok()) return chosen.error();
    const auto [low, high] = axes_.front().range.value_or(std::pair{0.0, 1.0});
    return storage::countLeafDensities({std::string(leafDensity), axes_.front().bins, low, high},
                                       *step->points, chosen->get());
}

Result<storage::Histogram> HistogramPart::count(const StepQuestion& question, proto::Answer& message) {
    if (auto counted = countLeaves(question)) return *std::move(counted);
    MOTE_ASSIGN_OR_RETURN(const auto numbers, question.numbers());
    std::vector<storage::HistogramAxis> axes;
    for (std::size_t i = 0; i < axes_.size(); ++i) {
        auto& axis = axes_[i];
        if (!axis.range) {
            const auto range = storage::quantityRange(question.run(), axis.column, question.cancelled());
            if (!range.ok()) return atColumn(range.error(), i);
            axis.range = storage::widened(range->low, range->high);
        }
        axes.push_back({axis.column, axis.bins, axis.range->first, axis.range->second});
    }
    MOTE_ASSIGN_OR_RETURN(const auto chosen, question.chosen());
    MOTE_ASSIGN_OR_RETURN(const auto hold, question.take(storage::histogramBytes(axes)));
    auto counted = storage::countHistogram(axes, unweighted_, numbers, chosen.get(), question.cancelled());
    if (!counted.ok()) return counted;
    for (std::size_t i = 0; i < axes.size(); ++i) {
        for (auto& note : notesOfBins(*numbers.columns, axes_[i].column, counted->edges[i]))
            message.add_notes(std::move(note));
    }
    return counted;
}

MadePart histogramPart(const proto::HistogramQuery& query) {
    MOTE_ASSIGN_OR_RETURN(auto part, HistogramPart::make(query));
    return MadePart(std::move(part));
}

}  // namespace mote::server
