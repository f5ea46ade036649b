// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/region_graph.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "server/render/ink/direction.h"
#include "server/render/ink/segment_regions.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

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
