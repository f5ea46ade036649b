// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/numbers/quantity_range.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "storage/beam/quantity_reader.h"
#include "storage/numbers/scan.h"

namespace mote::storage {
namespace {

constexpr QuantityRange nothing{std::numeric_limits<double>::infinity(),
                                -std::numeric_limits<double>::infinity()};

constexpr double slack = 1e-6;

void widen(QuantityRange& range, double low, double high) {
    if (std::isfinite(low)) range.low = std::min(range.low, low);
    if (std::isfinite(high)) range.high = std::max(range.high, high);
}

std::optional<QuantityRange> ofManifest(const proto::ParticlesManifest& manifest, const std::string& name) {
    for (const auto& column : manifest.columns()) {
        if (column.name() == name) return QuantityRange{column.min(), column.max()};
    }
    const auto& names = manifest.statistic_names();
    const auto low = std::ranges::find(names, "min_" + name), high = std::ranges::find(names, "max_" + name);
    if (low == names.end() || high == names.end()) return std::nullopt;
    QuantityRange range = nothing;
    for (const auto& step : manifest.steps()) {
        widen(range, step.statistics(static_cast<int>(low - names.begin())),
              step.statistics(static_cast<int>(high - names.begin())));
    }
    // Those are of the source's own values; what is made from columns, which are rounded, may lie beyond.
    const double width = range.high - range.low;
    if (width > 0.0) widen(range, range.low - slack * width, range.high + slack * width);
    return range;
}

/// Of one step; nothing where `cancelled` says so.
std::optional<QuantityRange> ofStep(const QuantityReader& reader, std::uint64_t points,
                                    const std::function<bool()>& cancelled) {
    std::vector<QuantityRange> ranges(blockCount(points), nothing);
    const bool whole = forBlocks(ranges.size(), cancelled, [&](std::uint64_t block) {
        const auto part = pointsOfBlock(block, points);
        std::vector<double> values(part.count);
        QuantityReader::Scratch scratch;
        const std::array out{std::span(values)};
        reader.read(part.begin, part.count, scratch, out);
        for (const double value : values) widen(ranges[block], value, value);
    });
    if (!whole) return std::nullopt;
    QuantityRange range = nothing;
    for (const auto& one : ranges) widen(range, one.low, one.high);
    return range;
}

}  // namespace

Result<QuantityRange> quantityRange(const RunSteps& run, const std::string& name,
                                    const std::function<bool()>& cancelled) {
    if (const auto known = ofManifest(run.manifest(), name)) return *known;
    QuantityRange range = nothing;
    for (int step = 0; step < run.manifest().steps_size(); ++step) {
        MOTE_ASSIGN_OR_RETURN(const auto numbers, run.step(static_cast<std::uint32_t>(step)));
        if (!numbers.columns) return withoutColumns(name);
        MOTE_ASSIGN_OR_RETURN(const auto reader,
                              QuantityReader::make(*numbers.columns, numbers.context, std::span(&name, 1)));
        try {
            const auto own = ofStep(reader, numbers.columns->pointCount(), cancelled);
            if (!own) return Error{ErrorCode::cancelled, "", "cancelled"};
            widen(range, own->low, own->high);
        } catch (const StorageError& error) {
            return error.error();
        }
    }
    return range;
}

}  // namespace mote::storage
