// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/numbers/coarse_notes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <string_view>

#include "protocol/quantity/statistic.h"
#include "storage/beam/quantity_reader.h"

namespace mote::server {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// The step from a value to the next if a column has such values: floats about an offset are the finer
/// the nearer they are to it. 0: it holds them as the source does.
double stepOf(const storage::ColumnInfo& info, double low, double high) {
    const double most = std::max(std::abs(low - info.offset), std::abs(high - info.offset));
    if (info.doubles || !(most > 0.0)) return 0.0;
    const auto stored = static_cast<float>(most);
    const auto next = std::nextafter(stored, std::numeric_limits<float>::infinity());
    const double step = static_cast<double>(next - stored);
    return info.resolution > 0.0 ? std::min(step, info.resolution) : step;
}

const storage::ColumnInfo* columnOf(const storage::ParticleColumns& columns, const std::string& name) {
    const auto place = columns.find(name);
    return place ? &columns.columns()[*place] : nullptr;
}

/// The columns that a statistic is made from.
void addColumnsOf(std::string_view statistic, const storage::ParticleColumns& columns,
                  std::set<std::string, std::less<>>& all) {
    if (const auto known = findStatistic(statistic)) {
        const auto& own = statistics()[*known].columns;
        all.insert(own.begin(), own.end());
        return;
    }
    const auto parsed = parseQuantityStatistic(statistic);
    if (!parsed) return;
    for (const auto& name : parsed->quantities) {
        const auto quantity = Quantity::make(name, storage::runOf(columns, {}));
        if (!quantity.ok()) continue;
        for (const auto column : quantity->columns()) all.insert(columns.columns()[column].name);
    }
}

/// A set of particles as statistics tell of it: the greatest step of a column there, and its spread.
struct Spread {
    double step = 0.0, sigma = infinite;

    bool coarse() const { return sigma < fewestSteps * step; }
};

class Spreads {
  public:
    explicit Spreads(const storage::ColumnInfo& info) : info_(info) {
        const auto place = [&](const std::string& name) { return findStatistic(name); };
        const auto count = place("n_finite"), sigma = place("sigma_" + info.name);
        const auto low = place("min_" + info.name), high = place("max_" + info.name);
        known_ = count && sigma && low && high;
        if (known_) places_ = {*count, *sigma, *low, *high};
    }
    bool known() const { return known_; }
    Spread of(std::span<const double> values) const {
        // One particle has no spread, and none that is not a number is told of.
        if (!(values[places_[0]] > 1.0) || !std::isfinite(values[places_[1]])) return {};
        return {stepOf(info_, values[places_[2]], values[places_[3]]), values[places_[1]]};
    }

  private:
    const storage::ColumnInfo& info_;
    std::array<std::size_t, 4> places_{};
    bool known_ = false;
};

}  // namespace

std::vector<std::string> notesOfStatistics(const storage::ParticleColumns& columns,
                                           const storage::PointStatistics& found,
                                           std::span<const std::string> names) {
    std::set<std::string, std::less<>> asked;
    for (const std::string& name : names) addColumnsOf(name, columns, asked);
    std::vector<std::string> notes;
    for (const auto& info : columns.columns()) {
        const Spreads spreads(info);
        if (!spreads.known() || (!names.empty() && !asked.contains(info.name))) continue;
        Spread worst = spreads.of(found.values);
        const char* of = "these particles";
        for (const auto& slice : found.slices) {
            const Spread one = spreads.of(slice);
            if (worst.coarse() || !one.coarse()) continue;
            worst = one;
            of = "a slice";
        }
        if (!worst.coarse()) continue;
        notes.push_back(fmt::format(
            "{0} is held in steps of {1:.2g} {2} here, and the spread (sigma) of {3} is {4:.2g} {2}: "
            "what is said of {0} is coarse",
            info.name, worst.step, info.unit, of, worst.sigma));
    }
    return notes;
}

std::vector<std::string> notesOfBins(const storage::ParticleColumns& columns, const std::string& column,
                                     std::span<const double> edges) {
    const auto* const info = columnOf(columns, column);
    if (edges.size() < 2 || info == nullptr) return {};
    const double width = (edges.back() - edges.front()) / static_cast<double>(edges.size() - 1);
    const double step = stepOf(*info, edges.front(), edges.back());
    if (!(width < fewestStepsOfBin * step)) return {};
    return {
        fmt::format("{0} is held in steps of {1:.2g} {2} here, and a bin is {3:.2g} {2} wide: neighbouring "
                    "bins differ for that alone",
                    column, step, info->unit, width)};
}

std::vector<std::string> notesOfValues(const storage::ParticleColumns& columns, const std::string& column,
                                       std::span<const double> values) {
    const auto* const info = columnOf(columns, column);
    if (values.size() < 2 || info == nullptr) return {};
    double low = infinite, high = -infinite;
    for (const double value : values) {
        if (!std::isfinite(value)) continue;
        low = std::min(low, value);
        high = std::max(high, value);
    }
    // One value of all: of coordinates that may be lost detail, of weights and the like it is what they are.
    const bool coordinate = findStatistic("sigma_" + column).has_value();
    if (!(low <= high) || (low == high && !coordinate)) return {};
    const double step = stepOf(*info, low, high);
    if (!(high - low < fewestSteps * step) || !(step > 0.0)) return {};
    return {
        fmt::format("{} is held in steps of {:.2g} {} here, and these particles span fewer than {} of them",
                    column, step, info->unit, fewestSteps)};
}

}  // namespace mote::server
