// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/numbers/bin_axis.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace mote::storage {

std::pair<double, double> widened(double low, double high) {
    if (low > high) return {0.0, 1.0};
    if (low < high) return {low, high};
    const double half = std::max(0.5, 1e-9 * std::abs(low));
    return {low - half, high + half};
}

std::vector<double> evenEdges(std::uint32_t bins, double low, double high) {
    std::vector<double> edges(std::size_t{bins} + 1);
    const double width = (high - low) / bins;
    for (std::uint32_t i = 0; i < bins; ++i) edges[i] = low + i * width;
    edges[bins] = high;
    return edges;
}

std::uint32_t binOf(std::span<const double> edges, double value) {
    const auto bins = static_cast<std::uint32_t>(edges.size()) - 1;
    if (!(value >= edges.front() && value <= edges.back())) return bins;
    const double share = (value - edges.front()) / (edges.back() - edges.front());
    auto bin = std::min(static_cast<std::uint32_t>(share * bins), bins - 1);
    // Rounding, of the share or of an edge.
    while (bin > 0 && value < edges[bin]) --bin;
    while (bin + 1 < bins && value >= edges[bin + 1]) ++bin;
    return bin;
}

Result<BinAxis> BinAxis::make(const StepNumbers& step, const std::string& column, std::uint32_t bins,
                              double low, double high) {
    const auto& columns = *step.columns;
    MOTE_ASSIGN_OR_RETURN(auto reader, QuantityReader::make(columns, step.context, std::span(&column, 1)));
    BinAxis axis(columns, std::move(reader), evenEdges(bins, low, high));
    if (const auto stored = columns.find(column); stored && !columns.columns()[*stored].doubles) {
        axis.floats_ = FloatBins(columns.columns()[*stored].offset, axis.edges_);
        axis.column_ = *stored;
    }
    return axis;
}

Result<BinAxis> BinAxis::make(const StepNumbers& step, const std::string& column, std::vector<double> edges) {
    const auto& columns = *step.columns;
    MOTE_ASSIGN_OR_RETURN(auto reader, QuantityReader::make(columns, step.context, std::span(&column, 1)));
    BinAxis axis(columns, std::move(reader), std::move(edges));
    axis.even_ = false;
    return axis;
}

namespace {

std::uint32_t unevenBin(std::span<const double> edges, double value) {
    const auto bins = static_cast<std::uint32_t>(edges.size()) - 1;
    if (!(value >= edges.front() && value <= edges.back())) return bins;
    const auto after = std::upper_bound(edges.begin() + 1, edges.end() - 1, value);
    return static_cast<std::uint32_t>(after - edges.begin()) - 1;
}

}  // namespace

void BinAxis::find(PointRange block, Scratch& scratch, std::span<std::uint32_t> out) const {
    if (column_) return floats_.find(columns_->values(*column_, block.begin, block.count), out);
    scratch.values.resize(block.count);
    const std::array values{std::span(scratch.values)};
    reader_.read(block.begin, block.count, scratch.reader, values);
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = even_ ? binOf(edges_, scratch.values[i]) : unevenBin(edges_, scratch.values[i]);
}

}  // namespace mote::storage
