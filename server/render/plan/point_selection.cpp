// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/point_selection.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_reduce.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "protocol/scene/drawn_points.h"
#include "server/render/plan/octree_cell.h"

namespace mote::render {
namespace {

/// So few nodes are walked in a moment; of more, only a part in view that is small.
constexpr std::size_t fewNodes = std::size_t{1} << 16;
constexpr double smallPart = 0.25;
constexpr std::uint8_t roughLevel = 4;
constexpr std::size_t blockLeaves = std::size_t{1} << 14;

/// The density at scaled log density t, a little raised, so that no leaf is lost by rounding.
double densityAt(const LogDensity& scale, double t) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    if (!(scale.max > scale.min)) return t > 0.0 ? infinite : 0.0;  // all leaves have t = 0
    if (t > 1.0) return infinite;
    return scale.min * std::exp(t * std::log(scale.max / scale.min)) * (1.0 + 1e-6);
}

/// The curve's fraction of leaf after leaf; equal densities, common in a run of equal weights, are looked up
/// once.
class LeafFraction {
  public:
    LeafFraction(const Curve& curve, const LogDensity& scale) : curve_(curve), scale_(scale) {}
    double operator()(float density) {
        if (density != density_) {
            density_ = density;
            fraction_ = curve_(scale_.ofLeaf(density));
        }
        return fraction_;
    }

  private:
    const Curve& curve_;
    LogDensity scale_;
    float density_ = std::numeric_limits<float>::quiet_NaN();
    double fraction_ = 0.0;
};

class InView {
  public:
    InView(const storage::ParticleStep& step, const Frustum& frustum, double densityLimit)
        : nodes_(step.nodes()), leaves_(step.leaves().size()), frustum_(frustum), limit_(densityLimit) {}

    /// Particles below the nodes of `roughLevel` that are in view, or above it.
    std::uint64_t roughCount() {
        std::uint64_t count = 0;
        walk([&](std::size_t node) {
            if (nodes_.childCount[node] != 0 && nodes_.level[node] < roughLevel) return true;
            count += nodes_.count[node];
            return false;
        });
        return count;
    }

    std::vector<std::uint64_t> bits() {
        std::vector<std::uint64_t> bits((leaves_ + 63) / 64, 0);
        walk([&](std::size_t node) {
            if (nodes_.childCount[node] != 0) return true;
            const std::size_t leaf = nodes_.firstChild[node];
            bits[leaf / 64] |= std::uint64_t{1} << (leaf % 64);
            return false;
        });
        return bits;
    }

  private:
    struct Visit {
        std::uint32_t node;
        Frustum::Side side;
    };

    Frustum::Side sideOf(std::size_t node) const {
        const double half = std::ldexp(1.0, -nodes_.level[node]);
        const glm::dvec3 place(cellPlace(nodes_.morton[node]));
        return frustum_.of(glm::dvec3(-1.0) + 2.0 * half * (place + 0.5), half);
    }

    /// Depth first over the nodes in view; `enter` says whether to go below.
    void walk(const std::function<bool(std::size_t)>& enter) {
        if (nodes_.size() == 0) return;
        stack_.assign(1, {0, Frustum::Side::partly});
        while (!stack_.empty()) {
            auto [node, side] = stack_.back();
            stack_.pop_back();
            if (nodes_.count[node] == 0 || nodes_.minDensity[node] > limit_) continue;
            if (side == Frustum::Side::partly) side = sideOf(node);
            if (side == Frustum::Side::outside || !enter(node)) continue;
            for (std::uint32_t i = 0; i < nodes_.childCount[node]; ++i)
                stack_.push_back({nodes_.firstChild[node] + i, side});
        }
    }

    const storage::OctreeNodes nodes_;
    const std::size_t leaves_;
    const Frustum& frustum_;
    const double limit_;
    std::vector<Visit> stack_;
};

/// The density above which no leaf draws anything.
double limitOf(const LogDensity& scale, const PointChoice& choice) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    return choice.thin() ? infinite : densityAt(scale, zeroFrom(choice.fraction));
}

/// The upper half of a float, rounded.
std::uint16_t upperHalf(double value) {
    const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
    return static_cast<std::uint16_t>((bits + 0x8000U) >> 16);
}

/// What the points of each leaf weigh over the mean of the plot: the mean of its own.
class LeafWeights {
  public:
    LeafWeights(const storage::ParticleStep& step, double mean)
        : leaves_(step.leaves()), nodes_(step.nodes()), mean_(mean) {}

    double operator()(std::size_t leaf) const {
        const double weight = leaves_.density[leaf] * cellShare(nodes_.level[leaves_.node[leaf]]);
        return weight / (std::max<double>(leaves_.pointCount[leaf], 1.0) * mean_);
    }

    /// Whether the first so many leaves have the weight of the first.
    bool even(std::size_t count) const {
        constexpr double alike = 1e-3;
        const double first = count > 0 ? (*this)(0) : 1.0;
        std::atomic<bool> differ{false};
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, blockLeaves), [&](const auto& block) {
            if (differ.load(std::memory_order_relaxed)) return;
            for (std::size_t i = block.begin(); i < block.end(); ++i) {
                if (std::abs((*this)(i)-first) > alike * first) differ.store(true, std::memory_order_relaxed);
            }
        });
        return !differ;
    }

  private:
    const storage::Leaves leaves_;
    const storage::OctreeNodes nodes_;
    const double mean_;
};

void weigh(const storage::ParticleStep& step, const PointChoice& choice, PointSelection& selection) {
    const LeafWeights weightOf(step, choice.meanWeight);
    const std::size_t count = selection.drawn.size();
    const bool thinned = choice.thinning.tau > 0.0;
    const ThinnedWeights weights(choice.thinning, choice.share);
    const auto here = [&](std::size_t leaf) {
        const double weight = weightOf(leaf);
        return thinned && weight > 0.0 ? weights.weightHere(weight) : weight;
    };
    selection.weight = count > 0 ? static_cast<float>(here(0)) : 1.0F;
    if (weightOf.even(count)) return;
    selection.weights.resize(count);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, blockLeaves), [&](const auto& block) {
        for (std::size_t i = block.begin(); i < block.end(); ++i) selection.weights[i] = upperHalf(here(i));
    });
}

/// docs/PICTURE.md, "Colour by density".
void tellLevels(const storage::ParticleStep& step, const PointChoice& choice, PointSelection& selection) {
    const auto leaves = step.leaves();
    const auto nodes = step.nodes();
    const DensityLevels levels(*choice.shade, step.logDensity());
    const StepVolume* const volume = choice.volume.get();
    const bool smooth = volume != nullptr && !volume->empty();
    selection.levels.resize(selection.drawn.size());
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, selection.levels.size(), blockLeaves), [&](const auto& block) {
            for (std::size_t i = block.begin(); i < block.end(); ++i) {
                if (selection.drawn[i] == 0) continue;
                std::uint8_t& level = selection.levels[i];
                level = levels.of(leaves.density[i]);
                if (level == 0 || !smooth) continue;
                const std::size_t node = leaves.node[i];
                const double edge = std::ldexp(1.0, -nodes.level[node]);
                const glm::dvec3 middle = edge * (glm::dvec3(cellPlace(nodes.morton[node])) + 0.5);
                const auto tone = volume->toneAt(middle);
                level = DensityLevels::at(*choice.shade, tone.t, tone.held);
            }
        });
}

}  // namespace

StepWeight stepWeight(const storage::ParticleStep& step, double meanWeight) {
    const std::size_t leaves = step.leaves().size();
    if (leaves == 0) return {};
    const LeafWeights weightOf(step, meanWeight);
    if (weightOf.even(leaves)) return {weightOf(0), true};
    const double all = static_cast<double>(step.nodes().density[0]);
    return {all / (static_cast<double>(step.pointCount()) * meanWeight), false};
}

StepWeight roughStepWeight(const storage::ParticleStep& step, double meanWeight) {
    const auto densities = step.volume();
    if (densities.empty() || step.pointCount() == 0) return {};
    const double all = std::accumulate(densities.begin(), densities.end(), 0.0);
    const double perPoint = static_cast<double>(densities.size()) * static_cast<double>(step.pointCount());
    return {all / (perPoint * meanWeight), true};
}

PointSelection selectPoints(const storage::ParticleStep& step, const PointChoice& choice) {
    const auto leaves = step.leaves();
    const auto nodes = step.nodes();
    const LogDensity scale = step.logDensity();
    // Leaves ascend in density: beyond the limit there is nothing to draw.
    const auto end = std::upper_bound(leaves.density.begin(), leaves.density.end(), limitOf(scale, choice));
    PointSelection selection;
    selection.drawn.resize(static_cast<std::size_t>(end - leaves.density.begin()));
    const LeafWeights weightOf(step, choice.meanWeight);
    const ThinnedWeights weights(choice.thinning, choice.share);
    const bool byWeight = choice.thinning.tau > 0.0 && choice.meanWeight > 0.0;
    const auto select = [&](const tbb::blocked_range<std::size_t>& block, std::uint64_t points) {
        LeafFraction fractionOf(choice.fraction, scale);
        const StepVolume* const volume = choice.thin() ? choice.volume.get() : nullptr;
        for (std::size_t i = block.begin(); i < block.end(); ++i) {
            const double byCurve = fractionOf(leaves.density[i]);
            const double whole = volume == nullptr ? byCurve : 1.0 - (1.0 - byCurve) * volume->shareOf(i);
            const double weight = byWeight ? weightOf(i) : 0.0;
            const double share = weight > 0.0 ? weights.share(weight) : choice.share;
            const double fraction = share * whole;
            const std::size_t node = leaves.node[i];
            std::uint32_t drawn = 0;
            if (fraction >= 1.0) {
                drawn = leaves.pointCount[i];
            } else if (fraction > 0.0) {
                drawn = drawnPoints(fraction, leaves.pointCount[i], nodes.level[node], nodes.morton[node]);
            }
            selection.drawn[i] = drawn;
            points += drawn;
        }
        return points;
    };
    selection.points =
        tbb::parallel_reduce(tbb::blocked_range<std::size_t>(0, selection.drawn.size(), blockLeaves),
                             std::uint64_t{0}, select, std::plus<>());
    if (choice.meanWeight > 0.0) weigh(step, choice, selection);
    if (choice.shade) tellLevels(step, choice, selection);
    return selection;
}

double zeroFrom(const Curve& curve) {
    const auto& knots = curve.knots();
    if (knots.back().y > 0.0) return std::numeric_limits<double>::infinity();
    const auto positive = [](const Curve::Knot& knot) { return knot.y > 0.0; };
    const auto last = std::find_if(knots.rbegin(), knots.rend(), positive);
    return last == knots.rend() ? 0.0 : last.base()->x;
}

std::vector<storage::PointRange> neededPoints(const storage::ParticleStep& step, const PointChoice& choice) {
    constexpr std::uint64_t close = std::uint64_t{1}
                                    << 16;  // points: reading on costs less than another range
    const auto leaves = step.leaves();
    const double limit = densityAt(step.logDensity(), zeroFrom(choice.fraction));
    const auto end = static_cast<std::size_t>(
        std::upper_bound(leaves.density.begin(), leaves.density.end(), limit) - leaves.density.begin());
    std::vector<storage::PointRange> ranges;
    const auto add = [&](std::uint64_t begin, std::uint64_t pointsEnd) {
        if (ranges.empty() || begin > ranges.back().begin + ranges.back().count + close)
            ranges.push_back({begin, 0});
        ranges.back().count = pointsEnd - ranges.back().begin;
    };
    if (end > 0) add(0, end == leaves.size() ? step.pointCount() : leaves.pointBegin[end]);
    if (!choice.thin()) return ranges;
    for (std::size_t i = end; i < leaves.size(); ++i) {
        if (choice.volume->share[i] < 255)
            add(leaves.pointBegin[i], leaves.pointBegin[i] + leaves.pointCount[i]);
    }
    return ranges;
}

std::vector<std::uint64_t> leavesInView(const storage::ParticleStep& step, const Frustum& frustum,
                                        const PointChoice& choice) {
    if (frustum.of(glm::dvec3(0.0), 1.0) == Frustum::Side::inside) return {};
    InView view(step, frustum, limitOf(step.logDensity(), choice));
    const auto few = [&] {
        return static_cast<double>(view.roughCount()) <= smallPart * static_cast<double>(step.pointCount());
    };
    if (step.nodes().size() > fewNodes && !few()) return {};
    return view.bits();
}

}  // namespace mote::render
