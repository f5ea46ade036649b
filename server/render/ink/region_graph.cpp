// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/region_graph.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <utility>

#include "server/render/ink/complexity.h"
#include "server/render/ink/segment_regions.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

/// Pixels along a row or a column across the boundary of two neighbours: three before it and three behind it,
/// each set cut short where the surface ends.
struct Across {
    std::array<std::size_t, 3> before{}, behind{};  ///< nearest first
    std::size_t countBefore = 1, countBehind = 1;
};

/// Of two steps that are known, and slopes beside, what is not explained.
template <class T>
T unexplained(T step, const T* before, const T* behind) {
    T least = std::abs(step);
    if (before) least = std::min(least, std::abs(step - *before));
    if (behind) least = std::min(least, std::abs(step - *behind));
    return least;
}

struct Steps {
    double grey, angle, depth;
};

class WeightMaker {
  public:
    WeightMaker(const Modalities& modalities, const StepScales& scales, const std::stop_token& stop)
        : grey_(modalities.grey.values),
          depth_(modalities.depth.values),
          directions_(directionsOf(modalities.angle, stop)),
          scales_(scales),
          depthScale_(static_cast<float>(std::max(scales.depth * modalities.extent, 1e-30))) {}

    /// The steps between pixels at `first` and `first + stride`; `before` and `behind`: how many there are on
    /// either side.
    Steps steps(std::size_t first, std::size_t stride, std::size_t before, std::size_t behind) const {
        const auto across = acrossOf(first, stride, before, behind);
        return {greyStep(across), std::sqrt(angleStep(across)), depthStep(across)};
    }
    bool seen(std::size_t pixel) const { return std::isfinite(depth_[pixel]); }
    /// The weight of steps, with what adds to the squared scales of grey and angle.
    std::uint16_t weight(const Steps& steps, double grey, double angle) const {
        const double sum = square(steps.grey) / (square(scales_.grey) + grey) +
                           square(steps.angle) / (square(scales_.angle) + angle) +
                           square(steps.depth / static_cast<double>(depthScale_));
        if (!(sum < 20.0)) return PixelWeights::most;  // what is no number belongs to nothing
        return static_cast<std::uint16_t>(PixelWeights::most * (1.0 - std::exp(-sum)));
    }

  private:
    static double square(double value) { return value * value; }

    Across acrossOf(std::size_t first, std::size_t stride, std::size_t before, std::size_t behind) const {
        Across across;
        across.before[0] = first;
        across.behind[0] = first + stride;
        const float most = std::abs(depth_[first + stride] - depth_[first]) + depthScale_;
        const auto goesOn = [&](std::size_t from, std::size_t to) {
            return std::abs(depth_[to] - depth_[from]) <= most;
        };
        for (std::size_t i = 1; i < 3 && i <= before && goesOn(first - (i - 1) * stride, first - i * stride);
             ++i)
            across.before[across.countBefore++] = first - i * stride;
        for (std::size_t i = 1; i < 3 && i <= behind && goesOn(first + i * stride, first + (i + 1) * stride);
             ++i)
            across.behind[across.countBehind++] = first + (i + 1) * stride;
        return across;
    }
    double depthStep(const Across& across) const {
        const auto at = [this](std::size_t i) { return static_cast<double>(depth_[i]); };
        const double before = at(across.before[0]) - at(across.before[1]);
        const double behind = at(across.behind[1]) - at(across.behind[0]);
        return unexplained(at(across.behind[0]) - at(across.before[0]),
                           across.countBefore > 1 ? &before : nullptr,
                           across.countBehind > 1 ? &behind : nullptr);
    }
    double greyStep(const Across& across) const {
        const auto side = [this](const std::array<std::size_t, 3>& pixels, std::size_t count) {
            const auto near = static_cast<double>(grey_[pixels[0]]);
            return count > 1 ? 0.5 * (near + static_cast<double>(grey_[pixels[1]])) : near;
        };
        const auto at = [this](std::size_t i) { return static_cast<double>(grey_[i]); };
        const double before = at(across.before[0]) - at(across.before[2]);
        const double behind = at(across.behind[2]) - at(across.behind[0]);
        return unexplained(side(across.behind, across.countBehind) - side(across.before, across.countBefore),
                           across.countBefore > 2 ? &before : nullptr,
                           across.countBehind > 2 ? &behind : nullptr);
    }
    /// The square of the sine of a turn, less the turn before or behind.
    double angleStep(const Across& across) const {
        const auto turn = [this](std::size_t from, std::size_t to) {
            const auto &a = directions_[from], &b = directions_[to];
            return Direction{a.x * b.x + a.y * b.y, a.x * b.y - a.y * b.x};
        };
        const auto one = turn(across.before[0], across.behind[0]);
        if (one.x == 0.0F && one.y == 0.0F) return 0.0;
        double cosine = static_cast<double>(one.x);
        const auto explain = [&](const Direction& other) {
            if (other.x == 0.0F && other.y == 0.0F) return;
            cosine = std::max(cosine, static_cast<double>(one.x * other.x + one.y * other.y));
        };
        if (across.countBefore > 1) explain(turn(across.before[1], across.before[0]));
        if (across.countBehind > 1) explain(turn(across.behind[0], across.behind[1]));
        return 0.5 * std::max(0.0, 1.0 - cosine);
    }

    const std::vector<float>&grey_, &depth_;
    const std::vector<Direction> directions_;
    const StepScales scales_;
    const float depthScale_;
};

/// take(pixel, direction, steps) for all pairs of what is seen.
template <class Take>
void eachPair(const Modalities& modalities, const WeightMaker& maker, const std::stop_token& stop,
              const Take& take) {
    const std::uint32_t width = modalities.grey.width, height = modalities.grey.height;
    forInTurns(std::uint32_t{0}, height, [&](std::uint32_t row) {
        if (isStopped(stop)) return;
        for (std::uint32_t column = 0; column < width; ++column) {
            const auto i = modalities.grey.index(column, row);
            if (!maker.seen(i)) continue;
            if (column + 1 < width && maker.seen(i + 1))
                take(i, PixelWeights::right, maker.steps(i, 1, column, width - column - 2));
            if (row + 1 < height && maker.seen(i + width))
                take(i, PixelWeights::down, maker.steps(i, width, row, height - row - 2));
        }
    });
}

using RegionLink = RegionGraph::Link;

/// Links of one pair of regions become one, in the order of pairs.
void gather(std::vector<RegionLink>& links) {
    std::stable_sort(links.begin(), links.end(), [](const RegionLink& one, const RegionLink& other) {
        return std::pair(one.a, one.b) < std::pair(other.a, other.b);
    });
    std::size_t count = 0;
    for (const auto& link : links) {
        if (count > 0 && links[count - 1].a == link.a && links[count - 1].b == link.b) {
            links[count - 1].affinity += link.affinity;
            links[count - 1].length += link.length;
        } else {
            links[count++] = link;
        }
    }
    links.resize(count);
}

/// Sums of doubled directions.
struct RegionDirection {
    double x = 0.0, y = 0.0;
};

class Melting {
  public:
    Melting(const Segments& segments, const Modalities& modalities, const PixelWeights& weights,
            const std::stop_token& stop)
        : links_(regionGraphOf(segments, weights, stop).links),
          merges_(segments.count),
          directions_(segments.count) {
        const auto directions = directionsOf(modalities.angle, stop);
        for (std::size_t i = 0; i < directions.size(); ++i) {
            if (i % segments.label.width == 0 && isStopped(stop)) return;
            const auto label = segments.label.values[i];
            if (label == Segments::nothing) continue;
            directions_[label].x += static_cast<double>(directions[i].x);
            directions_[label].y += static_cast<double>(directions[i].y);
        }
    }
    /// Each region that may joins the one that it belongs to most; whether any did.
    bool round(double most, double leastCosine) {
        std::vector<std::size_t> best(directions_.size(), links_.size());
        const auto offer = [&](std::uint32_t region, std::size_t link) {
            auto& own = best[region];
            if (own == links_.size() || mean(links_[link]) > mean(links_[own])) own = link;
        };
        for (std::size_t i = 0; i < links_.size(); ++i) {
            const auto& link = links_[i];
            if (!(mean(link) > most) || cosine(link.a, link.b) < leastCosine) continue;
            offer(link.a, i);
            offer(link.b, i);
        }
        bool any = false;
        for (std::size_t i = 0; i < links_.size(); ++i) {
            if (best[links_[i].a] != i || best[links_[i].b] != i) continue;
            join(links_[i].a, links_[i].b);
            any = true;
        }
        if (any) relabel();
        return any;
    }
    Merges& merges() { return merges_; }

  private:
    static double mean(const RegionLink& link) { return link.affinity / link.length; }
    double cosine(std::uint32_t a, std::uint32_t b) const {
        const auto &one = directions_[a], &other = directions_[b];
        const double length = std::hypot(one.x, one.y) * std::hypot(other.x, other.y);
        return length > 0.0 ? (one.x * other.x + one.y * other.y) / length : 1.0;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        merges_.merge(a, b);
        directions_[a].x += directions_[b].x;
        directions_[a].y += directions_[b].y;
    }
    void relabel() {
        std::size_t count = 0;
        for (const auto& link : links_) {
            const auto a = merges_.root(link.a), b = merges_.root(link.b);
            if (a != b) links_[count++] = {std::min(a, b), std::max(a, b), link.affinity, link.length};
        }
        links_.resize(count);
        gather(links_);
    }

    std::vector<RegionLink> links_;
    Merges merges_;
    std::vector<RegionDirection> directions_;
};

}  // namespace

Roughness roughnessOf(const Modalities& modalities, double deviation, const std::stop_token& stop) {
    const auto& depth = modalities.depth;
    const auto& part = modalities.part.values;
    Roughness made{Raster<float>(depth.width, depth.height), Raster<float>(depth.width, depth.height)};
    eachPair(modalities, WeightMaker(modalities, {}, stop), stop,
             [&](std::size_t i, std::size_t direction, const Steps& steps) {
                 if (part[i] != part[direction == PixelWeights::right ? i + 1 : i + depth.width]) return;
                 if (steps.grey <= 1.0) made.grey.values[i] += 0.5F * static_cast<float>(steps.grey);
                 if (steps.angle <= 1.0) made.angle.values[i] += 0.5F * static_cast<float>(steps.angle);
             });
    for (auto* const one : {&made.grey, &made.angle})
        *one = blurredWithin(*one, depth, modalities.extent, deviation, stop);
    return made;
}

PixelWeights stepWeights(const Modalities& modalities, const StepScales& scales, const std::stop_token& stop,
                         const Roughness* roughness, double rough) {
    PixelWeights made{modalities.grey.width, modalities.grey.height,
                      std::vector<std::uint16_t>(2 * modalities.grey.values.size(), PixelWeights::parted)};
    const WeightMaker maker(modalities, scales, stop);
    const auto& part = modalities.part.values;
    const auto more = [&](const Raster<float>& of, std::size_t i, std::size_t other) {
        const double mean = 0.5 * rough * static_cast<double>(of.values[i] + of.values[other]);
        return mean * mean;
    };
    eachPair(modalities, maker, stop, [&](std::size_t i, std::size_t direction, const Steps& steps) {
        const std::size_t pair = 2 * i + direction, other = made.other(pair);
        if (part[i] != part[other]) {
            made.of[pair] = PixelWeights::most;
            return;
        }
        made.of[pair] =
            roughness ? maker.weight(steps, more(roughness->grey, i, other), more(roughness->angle, i, other))
                      : maker.weight(steps, 0.0, 0.0);
    });
    return made;
}

RegionGraph regionGraphOf(const Segments& segments, const PixelWeights& weights,
                          const std::stop_token& stop) {
    RegionGraph graph;
    graph.inside.resize(segments.count);
    const auto& labels = segments.label.values;
    for (std::size_t pair = 0; pair < weights.of.size(); ++pair) {
        if (pair % weights.width == 0 && isStopped(stop)) return {};
        if (weights.of[pair] == PixelWeights::parted) continue;
        const auto a = labels[pair / 2], b = labels[weights.other(pair)];
        const double affinity = PixelWeights::affinity(weights.of[pair]);
        if (a == b)
            graph.inside[a] += 2.0 * affinity;
        else
            graph.links.push_back({std::min(a, b), std::max(a, b), affinity, 1.0});
    }
    gather(graph.links);
    return graph;
}

Segments melted(Segments segments, const Modalities& modalities, const PixelWeights& weights, double most,
                double turn, const std::stop_token& stop) {
    if (isStopped(stop)) return segments;
    Melting melting(segments, modalities, weights, stop);
    const double leastCosine = turn < 0.5 * std::numbers::pi ? std::cos(2.0 * turn) : -1.0;
    while (!isStopped(stop) && melting.round(most, leastCosine)) {
    }
    renumber(segments, melting.merges(), stop);
    return segments;
}

}  // namespace mote::render
