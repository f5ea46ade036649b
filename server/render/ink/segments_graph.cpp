// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/segments_graph.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "server/render/ink/segment_regions.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr double graphScale = 30.0;  // pixels by which a weight of 1 is overcome
// However few pixels there are, what weighs more is a boundary: else a twig joins what lies far behind it.
constexpr float mostJoined = 0.9F;
constexpr std::size_t stopEvery = std::size_t{1} << 16;  // pairs

/// All pairs in the order of their weights, those of one weight in the order of pixels; none of the parted.
std::vector<std::uint32_t> sortedPairs(const PixelWeights& weights, const std::stop_token& stop) {
    std::vector<std::size_t> begin(PixelWeights::parted + std::size_t{1});
    for (const auto weight : weights.of) {
        if (weight != PixelWeights::parted) ++begin[weight + std::size_t{1}];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::uint32_t> pairs(begin.back());
    for (std::size_t pair = 0; pair < weights.of.size(); ++pair) {
        if (pair % stopEvery == 0 && isStopped(stop)) break;
        const auto weight = weights.of[pair];
        if (weight != PixelWeights::parted) pairs[begin[weight]++] = static_cast<std::uint32_t>(pair);
    }
    return pairs;
}

/// Regions that join while they are told apart by no more than what they are made of.
class Joining {
  public:
    Joining(std::size_t pixels, double scale)
        : scale_(static_cast<float>(scale)),
          merges_(static_cast<std::uint32_t>(pixels)),
          pixels_(pixels, 1U),
          most_(pixels, std::min(scale_, mostJoined)) {}

    void offer(std::uint32_t one, std::uint32_t other, float weight) {
        const auto a = merges_.root(one), b = merges_.root(other);
        if (a == b || weight > std::min(most_[a], most_[b])) return;
        merges_.merge(a, b);
        const auto into = std::min(a, b);
        pixels_[into] = pixels_[a] + pixels_[b];
        most_[into] = std::min(weight + scale_ / static_cast<float>(pixels_[into]), mostJoined);
    }
    Merges& merges() { return merges_; }

  private:
    const float scale_;
    Merges merges_;
    std::vector<std::uint32_t> pixels_;
    std::vector<float> most_;  // weight at which a region still joins others
};

}  // namespace

Segments joinedByWeight(const PixelWeights& weights, const Raster<float>& depth, double scale,
                        const std::stop_token& stop) {
    const std::size_t pixels = depth.values.size();
    Segments made{Raster<std::uint32_t>(depth.width, depth.height, Segments::nothing),
                  static_cast<std::uint32_t>(pixels)};
    if (isStopped(stop)) return made;
    const auto pairs = sortedPairs(weights, stop);
    if (isStopped(stop)) return made;
    Joining joining(pixels, scale);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        if (i % stopEvery == 0 && isStopped(stop)) return made;
        const std::size_t pair = pairs[i];
        joining.offer(static_cast<std::uint32_t>(pair / 2), static_cast<std::uint32_t>(weights.other(pair)),
                      static_cast<float>(weights.of[pair]) / float{PixelWeights::most});
    }
    for (std::size_t i = 0; i < pixels; ++i) {
        if (std::isfinite(depth.values[i])) made.label.values[i] = static_cast<std::uint32_t>(i);
    }
    renumber(made, joining.merges(), stop);
    return made;
}

Segments graphSegments(const Modalities& modalities, std::size_t leastPixels, const std::stop_token& stop) {
    auto made = joinedByWeight(stepWeights(modalities, {}, stop), modalities.depth, graphScale, stop);
    return withoutSmall(std::move(made), modalities, leastPixels, stop);
}

}  // namespace mote::render
