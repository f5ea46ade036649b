// SPDX-License-Identifier: GPL-3.0-or-later
#include <oneapi/tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "storage/numbers/bin_axis.h"
#include "storage/numbers/scan.h"

namespace mote::storage {
namespace {

/// In the order of the values; those of both zeros are one.
std::uint64_t orderOf(double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value + 0.0);
    constexpr std::uint64_t sign = std::uint64_t{1} << 63U;
    return (bits & sign) != 0 ? ~bits : bits | sign;
}
double valueOf(std::uint64_t order) {
    constexpr std::uint64_t sign = std::uint64_t{1} << 63U;
    return std::bit_cast<double>((order & sign) != 0 ? order & ~sign : ~order);
}

/// What lies between two orders, in which edges are.
struct WeightWindow {
    std::uint64_t first = 0, last = 0;  ///< both are in it
    std::uint64_t below = 0;            ///< shares of what lies below it
    int shift = 0;                      ///< a bin is 2^shift wide
    std::size_t bins = 0;               ///< where its bins begin among those of all

    std::size_t binOf(std::uint64_t order) const {
        return static_cast<std::size_t>((order - first) >> shift);
    }
};

struct WeightBin {
    std::uint64_t share = 0, count = 0;
};

struct WeightedOrder {
    std::uint64_t order = 0, share = 0;
};

/// Finds edges in passes over all points: windows are divided into bins until few points are in those that
/// hold an edge; these are sorted. Shares are whole numbers, so that threads may add them in any order.
class WeightEdges {
  public:
    WeightEdges(const StepNumbers& step, const QuantityReader& reader, const PointMask* chosen,
                const std::function<bool()>& cancelled)
        : columns_(*step.columns),
          reader_(reader),
          chosen_(chosen),
          weight_(columns_.find("weight")),
          cancelled_(cancelled) {}

    /// Nothing where it was told to stop.
    std::optional<std::vector<double>> find(std::uint32_t slices, double low, double high) {
        slices_ = slices;
        if (!findGreatest()) return std::nullopt;
        if (!(greatest_ > 0.0)) return evenEdges(slices, low, high);
        edges_.assign(std::size_t{slices} + 1, high);
        edges_.front() = low;
        windows_ = {{orderOf(low), orderOf(high), 0}};
        ofEdge_.assign(slices - 1, 0);
        while (slices > 1) {
            const auto counted = count();
            if (!counted) return std::nullopt;
            if (narrow(*counted)) break;
        }
        if (slices > 1 && !gather()) return std::nullopt;
        return std::move(edges_);
    }

  private:
    static constexpr std::size_t allBins = std::size_t{1} << 16, few = std::size_t{1} << 20;

    /// Calls `take` with the block's place and, for each point with a value, its order and its weight; on all
    /// threads.
    template <class Take>
    bool each(const Take& take) const {
        const auto points = columns_.pointCount();
        return forBlocks(blockCount(points), cancelled_, [&](std::uint64_t block) {
            const auto part = pointsOfBlock(block, points);
            std::vector<double> values(part.count), weights(part.count, 1.0);
            QuantityReader::Scratch scratch;
            const std::array out{std::span(values)};
            reader_.read(part.begin, part.count, scratch, out);
            if (weight_) columns_.read(*weight_, part.begin, weights);
            for (std::size_t i = 0; i < values.size(); ++i) {
                if (!std::isfinite(values[i]) || !std::isfinite(weights[i]) || !(weights[i] >= 0.0)) continue;
                if (chosen_ == nullptr || chosen_->chosen(part.begin + i))
                    take(orderOf(values[i]), weights[i]);
            }
        });
    }

    bool findGreatest() {
        tbb::enumerable_thread_specific<double> most(0.0);
        const bool whole =
            each([&](std::uint64_t, double weight) { most.local() = std::max(most.local(), weight); });
        for (const double one : most) greatest_ = std::max(greatest_, one);
        return whole;
    }

    std::uint64_t shareOf(double weight) const {
        return static_cast<std::uint64_t>(std::llround(std::ldexp(weight / greatest_, 31)));
    }

    /// Its window; their number where it is in none.
    std::size_t windowOf(std::uint64_t order) const {
        const auto after = std::ranges::upper_bound(windows_, order, {}, &WeightWindow::first);
        if (after == windows_.begin() || order > (after - 1)->last) return windows_.size();
        return static_cast<std::size_t>(after - windows_.begin()) - 1;
    }

    std::optional<std::vector<WeightBin>> count() {
        std::size_t bins = 0;
        for (auto& window : windows_) {
            window.shift = 0;
            while ((window.last - window.first) >> window.shift >= allBins / windows_.size()) ++window.shift;
            window.bins = bins;
            bins += window.binOf(window.last) + 1;
        }
        tbb::enumerable_thread_specific<std::vector<WeightBin>> counts(
            [&] { return std::vector<WeightBin>(bins); });
        const bool whole = each([&](std::uint64_t order, double weight) {
            const auto window = windowOf(order);
            if (window == windows_.size()) return;
            auto& bin = counts.local()[windows_[window].bins + windows_[window].binOf(order)];
            bin.share += shareOf(weight);
            ++bin.count;
        });
        if (!whole) return std::nullopt;
        std::vector<WeightBin> all(bins);
        for (const auto& each : counts) {
            for (std::size_t i = 0; i < bins; ++i) {
                all[i].share += each[i].share;
                all[i].count += each[i].count;
            }
        }
        if (total_ == 0) {
            for (const auto& bin : all) total_ += bin.share;
        }
        return all;
    }

    /// Whether so much lies below an edge, or more than belongs there: share > i/n of all.
    bool passes(std::size_t edge, std::uint64_t share) const {
        __extension__ using Wide = unsigned __int128;
        return Wide{share} * slices_ > Wide{total_} * (edge + 1);
    }

    /// Each edge's bin becomes its window. Whether few points are left, or nothing more can be told apart.
    bool narrow(const std::vector<WeightBin>& counted) {
        std::vector<WeightWindow> next;
        std::uint64_t points = 0;
        bool apart = false;
        for (std::size_t edge = 0; edge < ofEdge_.size(); ++edge) {
            const auto& window = windows_[ofEdge_[edge]];
            const std::size_t last = window.bins + window.binOf(window.last);
            std::uint64_t below = window.below;
            std::size_t bin = window.bins;
            while (bin < last && !passes(edge, below + counted[bin].share)) below += counted[bin++].share;
            const std::uint64_t first = window.first + (std::uint64_t{bin - window.bins} << window.shift);
            if (next.empty() || next.back().first != first) {
                const std::uint64_t wide = (std::uint64_t{1} << window.shift) - 1;
                next.push_back({first, std::min(window.last, first + wide), below});
                points += counted[bin].count;
                apart = apart || window.shift > 0;
            }
            ofEdge_[edge] = next.size() - 1;
        }
        windows_ = std::move(next);
        return points <= few || !apart;
    }

    /// Sorts what lies in the windows, or takes windows of one value as they are.
    bool gather() {
        if (std::ranges::all_of(windows_, [](const auto& one) { return one.first == one.last; })) {
            for (std::size_t edge = 0; edge < ofEdge_.size(); ++edge)
                edges_[edge + 1] = valueOf(windows_[ofEdge_[edge]].first);
            return true;
        }
        tbb::enumerable_thread_specific<std::vector<WeightedOrder>> gathered;
        const bool whole = each([&](std::uint64_t order, double weight) {
            if (windowOf(order) < windows_.size()) gathered.local().push_back({order, shareOf(weight)});
        });
        std::vector<WeightedOrder> all;
        for (const auto& each : gathered) all.insert(all.end(), each.begin(), each.end());
        std::ranges::sort(all, {}, &WeightedOrder::order);
        for (std::size_t edge = 0; edge < ofEdge_.size(); ++edge) {
            const auto& window = windows_[ofEdge_[edge]];
            auto at = std::ranges::lower_bound(all, window.first, {}, &WeightedOrder::order);
            std::uint64_t below = window.below;
            while (at != all.end() && at->order <= window.last && !passes(edge, below + at->share))
                below += (at++)->share;
            const bool within = at != all.end() && at->order <= window.last;
            edges_[edge + 1] = valueOf(within ? at->order : window.last);
        }
        return whole;
    }

    const ParticleColumns& columns_;
    const QuantityReader& reader_;
    const PointMask* const chosen_;
    const std::optional<std::size_t> weight_;
    const std::function<bool()>& cancelled_;
    double greatest_ = 0.0;
    std::uint64_t total_ = 0;  ///< shares of all
    std::uint32_t slices_ = 1;
    std::vector<WeightWindow> windows_;  ///< ascending
    std::vector<std::size_t> ofEdge_;    ///< by edge between the first and the last: its window
    std::vector<double> edges_;
};

}  // namespace

std::optional<std::vector<double>> edgesOfEqualWeight(const StepNumbers& step, const QuantityReader& reader,
                                                      const PointMask* chosen, std::uint32_t slices,
                                                      double low, double high,
                                                      const std::function<bool()>& cancelled) {
    return WeightEdges(step, reader, chosen, cancelled).find(slices, low, high);
}

}  // namespace mote::storage
