// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/segments_texture.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "server/render/ink/complexity.h"
#include "server/render/ink/direction.h"
#include "server/render/ink/region_graph.h"
#include "server/render/ink/segment_regions.h"
#include "server/render/ink/segments_graph.h"

namespace mote::render {
namespace {

double env(const char* n, double d) {
    return std::getenv(n) ? std::atof(std::getenv(n)) : d;
}

const double greyScale = env("TG", 0.06);       // of means
const double energyScale = env("TE", 0.06);     // of edges along one direction
const double directionScale = env("TD", 0.35);  // of means of unit vectors
const double turnScale = env("TT", 0.35);       // of their differences from pixel to pixel
const double joinScale = env("TJ", 30.0);
const double meltedFrom = env("TM", 0.6);
constexpr double anyTurn = 4.0;

/// What is no number is nothing, and does not spread when it is blurred.
float held(float value) {
    return std::abs(value) <= 4.0F ? value : 0.0F;
}

/// Sums over channels of how much the windows on both sides of each pair of pixels differ, squared.
class WindowSteps {
  public:
    WindowSteps(const Modalities& modalities, PixelWeights surfaces, double deviation, std::size_t reach,
                const std::stop_token& stop)
        : modalities_(modalities),
          surfaces_(std::move(surfaces)),
          deviation_(deviation),
          reach_(reach),
          stop_(stop),
          sums_(surfaces_.of.size()) {}

    /// value(pixel) of a channel, and what step of its means is one.
    template <class Value>
    void add(double scale, const Value& value) {
        if (stop_.stop_requested()) return;
        const auto& depth = modalities_.depth;
        Raster<float> channel(depth.width, depth.height);
        eachRow([&](std::uint32_t row) {
            for (std::uint32_t column = 0; column < depth.width; ++column)
                channel.at(column, row) = held(value(channel.index(column, row)));
        });
        channel = blurredWithin(channel, depth, modalities_.extent, deviation_, stop_);
        const auto share = static_cast<float>(1.0 / scale);
        eachRow([&](std::uint32_t row) {
            for (std::uint32_t column = 0; column < depth.width; ++column) {
                const std::size_t i = depth.index(column, row);
                if (column + 1 < depth.width)
                    take(channel.values, i, PixelWeights::right, column, depth.width - column - 2, share);
                if (row + 1 < depth.height)
                    take(channel.values, i, PixelWeights::down, row, depth.height - row - 2, share);
            }
        });
    }
    /// The neighbour along a row or a column on the same surface, or the pixel itself.
    std::size_t next(std::size_t pixel, std::size_t direction) const {
        return joined(2 * pixel + direction) ? surfaces_.other(2 * pixel + direction) : pixel;
    }
    /// Steps of depth and of all channels as one weight.
    PixelWeights weights() {
        for (std::size_t pair = 0; pair < sums_.size(); ++pair) {
            auto& weight = surfaces_.of[pair];
            if (weight == PixelWeights::parted) continue;
            const double affinity = PixelWeights::affinity(weight) * std::exp(-static_cast<double>(sums_[pair]));
            weight = static_cast<std::uint16_t>(PixelWeights::most * (1.0 - affinity));
        }
        return std::move(surfaces_);
    }

  private:
    template <class Do>
    void eachRow(const Do& take) const {
        tbb::parallel_for(std::uint32_t{0}, modalities_.depth.height, [&](std::uint32_t row) {
            if (!stop_.stop_requested()) take(row);
        });
    }
    /// Whether depth makes no step between two.
    bool joined(std::size_t pair) const { return surfaces_.of[pair] < PixelWeights::most / 2; }
    /// How many pixels one can go on, at most `most`: `pair` is the first, a stride before or behind.
    std::size_t way(std::size_t pair, std::ptrdiff_t stride, std::size_t most) const {
        std::size_t count = 0;
        while (count < most && joined(pair)) {
            pair = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(pair) + stride);
            ++count;
        }
        return count;
    }
    /// Pixel `i` and the next along a direction; `before` and `behind`: how many there are on either side.
    void take(const std::vector<float>& channel, std::size_t i, std::size_t direction, std::size_t before,
              std::size_t behind, float share) {
        const std::size_t stride = direction == PixelWeights::right ? 1 : modalities_.depth.width;
        const std::size_t pair = 2 * i + direction, far = 3 * reach_;
        if (!joined(pair)) return;
        const auto pairStride = static_cast<std::ptrdiff_t>(2 * stride);
        const std::size_t wayBefore =
            before > 0 ? way(pair - 2 * stride, -pairStride, std::min(before, far)) : 0;
        const std::size_t wayBehind =
            behind > 0 ? way(pair + 2 * stride, pairStride, std::min(behind, far)) : 0;
        const float near = channel[i - std::min(reach_, wayBefore) * stride];
        const float other = channel[i + (1 + std::min(reach_, wayBehind)) * stride];
        float step = other - near, least = std::abs(step);
        const float span = 2.0F * static_cast<float>(reach_) + 1.0F;
        const auto explain = [&](float difference, std::size_t pixels) {
            least = std::min(least, std::abs(step - difference * span / static_cast<float>(pixels)));
        };
        if (wayBefore >= 2 * reach_) explain(near - channel[i - wayBefore * stride], wayBefore - reach_);
        if (wayBehind >= 2 * reach_)
            explain(channel[i + (1 + wayBehind) * stride] - other, wayBehind - reach_);
        sums_[pair] += least * least * share * share;
    }

    const Modalities& modalities_;
    PixelWeights surfaces_;
    const double deviation_;
    const std::size_t reach_;
    const std::stop_token& stop_;
    std::vector<float> sums_;
};

}  // namespace

Segments textureSegments(const Modalities& modalities, std::size_t leastPixels, const std::stop_token& stop) {
    constexpr double none = HUGE_VAL;
    const double side = std::sqrt(static_cast<double>(std::max<std::size_t>(leastPixels, 1)));
    const auto& grey = modalities.grey.values;
    const auto& angle = modalities.angle.values;
    StepScales scales{.grey = none, .angle = none};
    WindowSteps steps(modalities, stepWeights(modalities, scales, stop), env("TS", 0.4) * side,
                      static_cast<std::size_t>(env("TR", 3)), stop);
    const auto step = [&](std::size_t i, std::size_t a, std::size_t b) {
        return held(std::abs(grey[i] - 0.5F * (grey[a] + grey[b])));
    };
    steps.add(greyScale, [&](std::size_t i) { return grey[i]; });
    for (const std::size_t direction : {PixelWeights::right, PixelWeights::down}) {
        steps.add(energyScale, [&](std::size_t i) {
            const auto one = steps.next(i, direction);
            return step(i, one, one);
        });
    }
    steps.add(directionScale, [&](std::size_t i) { return directionOf(angle[i]).x; });
    steps.add(directionScale, [&](std::size_t i) { return directionOf(angle[i]).y; });
    steps.add(turnScale, [&](std::size_t i) {
        const auto a = directionOf(angle[i]);
        const auto b = directionOf(angle[steps.next(i, PixelWeights::right)]);
        const auto c = directionOf(angle[steps.next(i, PixelWeights::down)]);
        return 0.5F * (std::hypot(a.x - b.x, a.y - b.y) + std::hypot(a.x - c.x, a.y - c.y));
    });
    const auto weights = steps.weights();
    auto made = joinedByWeight(weights, modalities.depth, joinScale, stop);
    made = withoutSmall(std::move(made), modalities, leastPixels, stop);
    return melted(std::move(made), modalities, weights, meltedFrom, anyTurn, stop);
}

}  // namespace mote::render
