// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/numbers.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "protocol/quantity/expression.h"
#include "protocol/quantity/known_quantity.h"
#include "protocol/quantity/statistic.h"

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

ColumnUnits columnUnits(const proto::ParticlesManifest& manifest) {
    ColumnUnits units;
    for (const auto& known : knownQuantities()) units.emplace(known.name, known.unit);
    for (const auto& axis : manifest.axes()) units[axis.name()] = axis.unit();
    for (const auto& column : manifest.columns()) units[column.name()] = column.unit();
    return units;
}

std::string unitOfColumn(std::string_view column, const ColumnUnits& units) {
    if (const auto found = units.find(column); found != units.end()) return found->second;
    if (!Expression::looksLikeOne(column)) return {};
    const auto expression = Expression::parse(column);
    if (!expression.ok()) return {};
    std::vector<std::string> of;
    for (const auto& name : expression->names()) {
        const auto found = units.find(name.text);
        of.push_back(found == units.end() ? std::string() : found->second);
    }
    return expression->unit(of);
}

std::vector<std::string> columnsOf(std::string_view statistic) {
    if (const auto known = findStatistic(statistic)) return statistics()[*known].of;
    const auto parsed = parseQuantityStatistic(statistic);
    return parsed ? parsed->quantities : std::vector<std::string>();
}

std::string unitOf(std::string_view statistic, const ColumnUnits& units) {
    if (const auto known = findStatistic(statistic)) return statistics()[*known].unit;
    const auto parsed = parseQuantityStatistic(statistic);
    if (!parsed) return {};
    std::vector<std::string> of;
    for (const auto& quantity : parsed->quantities) of.push_back(unitOfColumn(quantity, units));
    return parsed->unit(of);
}

std::string withUnit(std::string_view name, std::string_view unit, bool told) {
    if (unit.empty() || (unit == "1" && !told)) return std::string(name);
    return fmt::format("{} [{}]", name, unit);
}

namespace {

constexpr std::array<std::string_view, 7> prefixable{"m", "s", "C", "eV", "eV/c", "rad", "A"};

struct Prefix {
    double scale;
    std::string_view letter;
};
constexpr std::array<Prefix, 12> prefixes{{{1e-18, "a"},
                                           {1e-15, "f"},
                                           {1e-12, "p"},
                                           {1e-9, "n"},
                                           {1e-6, "\u00b5"},
                                           {1e-3, "m"},
                                           {1.0, ""},
                                           {1e3, "k"},
                                           {1e6, "M"},
                                           {1e9, "G"},
                                           {1e12, "T"},
                                           {1e15, "P"}}};

/// Rounded to the digits that are shown, so that 999.9999 is no four-digit number of the prefix below.
double rounded(double magnitude) {
    return std::stod(fmt::format("{:.4e}", magnitude));
}

}  // namespace

std::string exactNumber(double value, std::string_view undefined) {
    return std::isfinite(value) ? fmt::format("{}", value) : std::string(undefined);
}

std::string csvField(std::string_view text) {
    if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
    std::string result = "\"";
    for (const char each : text) result += each == '"' ? "\"\"" : std::string(1, each);
    return result + '"';
}

ScaledUnit scaledUnit(double magnitude, std::string_view unit) {
    const ScaledUnit plain{1.0, unit == "1" ? std::string() : std::string(unit)};
    if (std::ranges::find(prefixable, unit) == prefixable.end()) return plain;
    if (!std::isfinite(magnitude) || magnitude == 0.0) return plain;
    const double size = rounded(std::abs(magnitude));
    const auto* chosen = prefixes.begin();
    for (const auto& prefix : prefixes) {
        if (prefix.scale <= size) chosen = &prefix;
    }
    return {chosen->scale, std::string(chosen->letter) + std::string(unit)};
}

std::string shortNumber(double value, const ScaledUnit& unit) {
    if (!std::isfinite(value)) return "-";
    const double scaled = value / unit.scale;
    if (scaled == 0.0) return "0";
    if (scaled == std::trunc(scaled) && std::abs(scaled) < 1e15) return fmt::format("{:.0f}", scaled);
    return fmt::format("{:#.5g}", scaled);
}

std::size_t widthOf(std::string_view text) {
    // Bytes of UTF-8 that begin a letter.
    return static_cast<std::size_t>(std::ranges::count_if(
        text, [](char each) { return (static_cast<unsigned char>(each) & 0xC0U) != 0x80U; }));
}

std::string padLeft(std::string_view text, std::size_t width) {
    const auto own = widthOf(text);
    return std::string(own < width ? width - own : 0, ' ') + std::string(text);
}

std::string padRight(std::string_view text, std::size_t width) {
    const auto own = widthOf(text);
    return std::string(text) + std::string(own < width ? width - own : 0, ' ');
}

}  // namespace mote::client
