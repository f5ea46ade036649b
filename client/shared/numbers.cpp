// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace mote::client {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::uint32_t defaultBins = 100, mostBins = 4096;  // of mote.proto's HistogramQuery

template <class Repeated>
auto listed(const Repeated& values) {
    return std::vector<typename Repeated::value_type>(values.begin(), values.end());
}

/// So many words of 8 bytes, all of the payload.
template <class T>
Result<std::vector<T>> wordsOf(const QueryAnswer& answer, std::uint64_t count, const char* where) {
    const auto bytes = answer.payload.size();
    if (bytes % sizeof(T) != 0 || bytes / sizeof(T) != count) {
        return corrupt(where, fmt::format("the server sent {} bytes where {} numbers belong", bytes, count));
    }
    std::vector<T> words(count);
    if (bytes > 0) std::memcpy(words.data(), answer.payload.data(), bytes);
    return words;
}

Status checkSlices(const StepStatistics& statistics) {
    const auto slices = statistics.slices.size();
    const bool each = std::ranges::all_of(
        statistics.slices, [&](const auto& slice) { return slice.size() == statistics.names.size(); });
    const bool edges =
        slices == 0 ? statistics.sliceEdges.empty() : statistics.sliceEdges.size() == slices + 1;
    if (each && edges) return success();
    return corrupt("answer.statistics", "the server's slices do not belong together");
}

/// Finite and ascending.
Status checkEdges(const std::vector<double>& edges) {
    for (std::size_t i = 0; i < edges.size(); ++i) {
        if (!std::isfinite(edges[i]) || (i > 0 && !(edges[i - 1] < edges[i])))
            return corrupt("answer.histogram", "the server's edges of bins do not ascend");
    }
    return success();
}

}  // namespace

Result<StepStatistics> statisticsOf(const QueryAnswer& answer) {
    const auto& message = answer.message;
    if (!message.has_statistics()) return corrupt("answer", "the server answered with something else");
    StepStatistics statistics{message.step(),
                              message.iteration(),
                              message.time(),
                              listed(message.statistics().names()),
                              listed(message.statistics().values()),
                              listed(message.statistics().slice_edges()),
                              {}};
    if (statistics.names.size() != statistics.values.size())
        return corrupt("answer.statistics", "the server's numbers do not belong to their names");
    for (const auto& slice : message.statistics().slices())
        statistics.slices.push_back(listed(slice.values()));
    MOTE_RETURN_IF_ERROR(checkSlices(statistics));
    statistics.notes = listed(message.notes());
    return statistics;
}

Result<StepHistogram> histogramOf(const QueryAnswer& answer, const proto::HistogramQuery& asked) {
    const auto& message = answer.message.histogram();
    if (!answer.message.has_histogram() || message.axes_size() != asked.axes_size() || asked.axes_size() == 0)
        return corrupt("answer", "the server answered with something else");
    StepHistogram histogram;
    histogram.step = answer.message.step();
    histogram.particles = message.particles();
    histogram.outside = message.outside();
    histogram.notes = listed(answer.message.notes());
    std::uint64_t bins = 1;
    for (int i = 0; i < asked.axes_size(); ++i) {
        const auto& axis = asked.axes(i);
        const auto wanted = axis.has_bins() ? axis.bins() : defaultBins;
        auto edges = listed(message.axes(i).values());
        if (wanted > mostBins || edges.size() != std::size_t{wanted} + 1)
            return corrupt("answer.histogram", "the server's bins are not those that were asked for");
        MOTE_RETURN_IF_ERROR(checkEdges(edges));
        bins *= wanted;
        histogram.columns.push_back(axis.column());
        histogram.edges.push_back(std::move(edges));
    }
    MOTE_ASSIGN_OR_RETURN(histogram.counts, wordsOf<double>(answer, bins, "answer.histogram"));
    return histogram;
}

Result<StepColumns> columnsOf(const QueryAnswer& answer, const proto::ColumnsQuery& asked) {
    const auto& message = answer.message.columns();
    const bool same = std::ranges::equal(message.names(), asked.names());
    const bool united = message.units().empty() || message.units_size() == message.names_size();
    if (!answer.message.has_columns() || !same || !united)
        return corrupt("answer.columns", "the server answered with other columns");
    if (!message.end() && message.next() <= asked.begin())
        return corrupt("answer.columns", "the server's pieces do not go on");
    const auto names = static_cast<std::uint64_t>(asked.names_size());
    if (message.count() > answer.payload.size())
        return corrupt("answer.columns", "the server's piece is not whole");
    MOTE_ASSIGN_OR_RETURN(const auto words,
                          wordsOf<std::uint64_t>(answer, message.count() * names, "answer.columns"));
    StepColumns columns{answer.message.step(), message.count(), {}, listed(message.units()), message.next(),
                        message.end(),         message.total()};
    for (auto begin = words.begin(); begin != words.end();) {
        const auto end = begin + static_cast<std::ptrdiff_t>(message.count());
        columns.words.emplace_back(begin, end);
        begin = end;
    }
    columns.words.resize(names);
    columns.notes = listed(answer.message.notes());
    return columns;
}

Result<std::vector<StepStatistics>> statisticsOf(const proto::ParticlesManifest& manifest,
                                                 const std::vector<std::size_t>& steps) {
    if (manifest.statistic_names().empty()) {
        return Error{
            ErrorCode::notFound, "",
            "the dataset was made before statistics were kept with it: make it again from its source "
            "(mote-prep particles) to have them"};
    }
    std::vector<StepStatistics> all;
    for (const auto index : steps) {
        const auto& entry = manifest.steps(static_cast<int>(index));
        if (entry.statistics_size() != manifest.statistic_names_size())
            return corrupt("manifest", "the dataset's statistics do not belong to their names");
        all.push_back({static_cast<std::uint32_t>(index),
                       entry.iteration(),
                       entry.time(),
                       listed(manifest.statistic_names()),
                       listed(entry.statistics()),
                       {},
                       {}});
    }
    return all;
}

}  // namespace mote::client
