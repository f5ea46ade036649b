// SPDX-License-Identifier: GPL-3.0-or-later
//
// Points are counted in a fixed number of parts, each with a table of its own, which are added one after the
// other: so sums of weights are the same on any number of threads. Where all weigh the same, what is counted
// are whole numbers.
#include "storage/numbers/histogram.h"

#include <fmt/format.h>
#include <oneapi/tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "storage/numbers/bin_axis.h"
#include "storage/numbers/scan.h"

namespace mote::storage {
namespace {

constexpr std::uint64_t mostTables = 32;
constexpr std::uint64_t mostTableBytes = std::uint64_t{128} << 20;  // of all parts

std::uint64_t binsOf(const std::vector<HistogramAxis>& axes) {
    std::uint64_t bins = 1;
    for (const auto& axis : axes) bins *= axis.bins;
    return bins;
}

/// Parts for tables of doubles.
std::uint64_t partsOf(std::uint64_t bins) {
    return std::clamp(mostTableBytes / (bins * sizeof(double)), std::uint64_t{1}, mostTables);
}

/// Of one part. Behind the bins comes one for all that lies outside.
template <class Count>
struct Table {
    std::vector<Count> counts;
    std::uint64_t particles = 0;
};

class Counter {
  public:
    Counter(std::vector<BinAxis> axes, const StepNumbers& step, const PointMask* chosen)
        : axes_(std::move(axes)), columns_(*step.columns), chosen_(chosen) {
        for (const auto& axis : axes_) bins_ *= axis.bins();
    }

    struct Scratch {
        BinAxis::Scratch axis;
        std::vector<std::uint32_t> first = std::vector<std::uint32_t>(blockPoints);
        std::vector<std::uint32_t> second = std::vector<std::uint32_t>(blockPoints);
    };

    std::uint64_t bins() const { return bins_; }

    /// Adds what add(point of the block) says to the bins of a block's points.
    template <class Count, class Add>
    void addBlock(PointRange block, Scratch& scratch, Table<Count>& table, const Add& add) const {
        std::span<const std::uint64_t> words;
        if (chosen_ != nullptr) {
            words = std::span(chosen_->words())
                        .subspan(block.begin / PointMask::wordBits, wordCount(block.count));
            if (!anyChosen(words)) return;
        }
        const auto places = std::span(scratch.first).first(block.count);
        findPlaces(block, scratch, places);
        const auto count = [&](std::size_t i) {
            table.counts[places[i]] += add(i);
            table.particles += places[i] < bins_ ? 1 : 0;
        };
        if (chosen_ != nullptr) return forEachChosen(words, count);
        for (std::size_t i = 0; i < places.size(); ++i) count(i);
    }

  private:
    /// The place of each point in the table.
    void findPlaces(PointRange block, Scratch& scratch, std::span<std::uint32_t> places) const {
        axes_[0].find(block, scratch.axis, places);
        if (axes_.size() == 1) return;
        const auto second = std::span(scratch.second).first(places.size());
        axes_[1].find(block, scratch.axis, second);
        const auto rows = axes_[0].bins(), columns = axes_[1].bins();
        const auto outside = static_cast<std::uint32_t>(bins_);
        for (std::size_t i = 0; i < places.size(); ++i) {
            const bool within = (places[i] < rows) & (second[i] < columns);
            places[i] = within ? places[i] * columns + second[i] : outside;
        }
    }

    const std::vector<BinAxis> axes_;
    const ParticleColumns& columns_;
    const PointMask* const chosen_;
    std::uint64_t bins_ = 1;
};

/// The one weight of all points, where they have one.
std::optional<double> oneWeight(const ParticleColumns& columns, std::optional<std::size_t> weight,
                                const std::function<bool()>& cancelled) {
    if (!weight) return 1.0;
    const auto points = columns.pointCount();
    if (points == 0) return 1.0;
    const double first = columns.value(*weight, 0);
    const float stored = columns.columns()[*weight].doubles ? 0.0F : columns.values(*weight, 0, 1)[0];
    std::atomic<bool> differs{!std::isfinite(first)};
    const auto stop = [&] { return differs.load(std::memory_order_relaxed) || (cancelled && cancelled()); };
    const bool whole = forBlocks(blockCount(points), stop, [&](std::uint64_t block) {
        const auto part = pointsOfBlock(block, points);
        const auto allAre = [](const auto values, auto one) {
            bool same = true;
            for (const auto value : values) same &= value == one;
            return same;
        };
        const bool same = columns.columns()[*weight].doubles
                              ? allAre(columns.doubles(*weight, part.begin, part.count), first)
                              : allAre(columns.values(*weight, part.begin, part.count), stored);
        if (!same) differs = true;
    });
    if (differs || !whole) return std::nullopt;
    return first;
}

/// All points count alike.
bool countAlike(const Counter& counter, std::uint64_t points, double weight,
                const std::function<bool()>& cancelled, Histogram& histogram) {
    struct Local {
        Counter::Scratch scratch;
        Table<std::uint32_t> table;
    };
    tbb::enumerable_thread_specific<Local> locals([&] {
        return Local{{}, {std::vector<std::uint32_t>(counter.bins() + 1, 0)}};
    });
    const bool whole = forBlocks(blockCount(points), cancelled, [&](std::uint64_t block) {
        auto& local = locals.local();
        counter.addBlock(pointsOfBlock(block, points), local.scratch, local.table,
                         [](std::size_t) { return 1U; });
    });
    if (!whole) return false;
    std::uint64_t outside = 0;
    for (const auto& local : locals) {
        for (std::size_t i = 0; i < histogram.counts.size(); ++i)
            histogram.counts[i] += local.table.counts[i];
        outside += local.table.counts.back();
        histogram.particles += local.table.particles;
    }
    for (auto& count : histogram.counts) count *= weight;
    histogram.outside = static_cast<double>(outside) * weight;
    return true;
}

bool countWeighted(const Counter& counter, const ParticleColumns& columns, std::size_t weight,
                   const std::function<bool()>& cancelled, Histogram& histogram) {
    const auto blocks = blockCount(columns.pointCount());
    const auto parts = std::min(partsOf(counter.bins()), std::max<std::uint64_t>(blocks, 1));
    std::vector<Table<double>> tables(parts);
    std::atomic<bool> stop{false};
    const auto stopNow = [&] { return stop || (cancelled && cancelled()); };
    struct Local {
        Counter::Scratch scratch;
        std::vector<double> weights;
    };
    tbb::enumerable_thread_specific<Local> locals;
    const bool whole = forBlocks(parts, stopNow, [&](std::uint64_t part) {
        auto& table = tables[part];
        table.counts.assign(counter.bins() + 1, 0.0);
        for (auto block = part * blocks / parts; block < (part + 1) * blocks / parts; ++block) {
            if (stopNow()) {
                stop = true;
                return;
            }
            const auto points = pointsOfBlock(block, columns.pointCount());
            auto& [scratch, weights] = locals.local();
            weights.resize(points.count);
            columns.read(weight, points.begin, weights);
            counter.addBlock(points, scratch, table, [&weights = weights](std::size_t i) {
                return std::isfinite(weights[i]) ? weights[i] : 0.0;
            });
        }
    });
    if (!whole || stop) return false;
    for (const auto& table : tables) {
        for (std::size_t i = 0; i < histogram.counts.size(); ++i) histogram.counts[i] += table.counts[i];
        histogram.outside += table.counts.back();
        histogram.particles += table.particles;
    }
    return true;
}

}  // namespace

Histogram countLeafDensities(const HistogramAxis& axis, const ParticleStep& step, const PointMask* chosen) {
    Histogram histogram;
    auto& edges = histogram.edges.emplace_back();
    for (std::uint32_t i = 0; i < axis.bins; ++i)
        edges.push_back(axis.low + i * ((axis.high - axis.low) / axis.bins));
    edges.push_back(axis.high);
    histogram.counts.assign(axis.bins, 0.0);
    const auto leaves = step.leaves();
    const auto scale = step.logDensity();
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
        const auto begin = leaves.pointBegin[leaf];
        const std::uint64_t points = chosen != nullptr ? chosen->count(begin, begin + leaves.pointCount[leaf])
                                                       : leaves.pointCount[leaf];
        const double density = scale.ofLeaf(static_cast<double>(leaves.density[leaf]));
        if (density < axis.low || density > axis.high) {
            histogram.outside += static_cast<double>(points);
            continue;
        }
        const auto above = std::upper_bound(edges.begin(), edges.end() - 1, density);
        histogram.counts[static_cast<std::size_t>(above - edges.begin()) - 1] += static_cast<double>(points);
        histogram.particles += points;
    }
    return histogram;
}

std::uint64_t histogramBytes(const std::vector<HistogramAxis>& axes) {
    const auto bins = binsOf(axes) + 1;
    return (partsOf(bins) + 1) * bins * sizeof(double);
}

Result<Histogram> countHistogram(const std::vector<HistogramAxis>& axes, bool unweighted,
                                 const StepNumbers& step, const PointMask* chosen,
                                 const std::function<bool()>& cancelled) {
    std::vector<BinAxis> made;
    Histogram histogram;
    for (const auto& axis : axes) {
        auto one = BinAxis::make(step, axis.column, axis.bins, axis.low, axis.high);
        if (!one.ok()) {
            const auto& error = one.error();  // at the name
            return Error{error.code, fmt::format("axes[{}].column", made.size()),
                         fmt::format("\"{}\" {}", error.where, error.message)};
        }
        histogram.edges.push_back(one->edges());
        made.push_back(*std::move(one));
    }
    const auto& columns = *step.columns;
    const auto weight = unweighted ? std::nullopt : columns.find("weight");
    const Counter counter(std::move(made), step, chosen);
    histogram.counts.assign(counter.bins(), 0.0);
    const auto alike = oneWeight(columns, weight, cancelled);
    const bool whole = alike ? countAlike(counter, columns.pointCount(), *alike, cancelled, histogram)
                             : countWeighted(counter, columns, weight.value_or(0), cancelled, histogram);
    if (!whole) return wasCancelled();
    columns.check();
    return histogram;
}

}  // namespace mote::storage
