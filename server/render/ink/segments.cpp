// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/segments.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

namespace mote::render {
namespace {

/// Calls take(neighbour, opposite, beyond) for the four neighbours of a pixel; `opposite` is the pixel on its
/// other side, or the pixel itself at the picture's side, and `beyond` that behind the neighbour, or this.
template <class Take>
void eachNeighbour(const Raster<float>& picture, std::size_t pixel, const Take& take) {
    const std::size_t width = picture.width, column = pixel % width, row = pixel / width;
    const bool left = column > 0, right = column + 1 < width, up = row > 0, down = row + 1 < picture.height;
    if (left) take(pixel - 1, right ? pixel + 1 : pixel, pixel - (column > 1 ? 2 : 1));
    if (right) take(pixel + 1, left ? pixel - 1 : pixel, pixel + (column + 2 < width ? 2 : 1));
    if (up) take(pixel - width, down ? pixel + width : pixel, pixel - (row > 1 ? 2 : 1) * width);
    if (down)
        take(pixel + width, up ? pixel - width : pixel, pixel + (row + 2 < picture.height ? 2 : 1) * width);
}

/// Grows one region after another. A Region is made of its seed and says joins(neighbour, from, opposite,
/// beyond) and add(pixel).
template <class MakeRegion>
Segments grow(const Modalities& modalities, const MakeRegion& makeRegion) {
    const auto& depth = modalities.depth;
    Segments made{Raster<std::uint32_t>(depth.width, depth.height, Segments::nothing), 0};
    std::vector<std::size_t> front;
    for (std::size_t seed = 0; seed < depth.values.size(); ++seed) {
        if (made.label.values[seed] != Segments::nothing || !std::isfinite(depth.values[seed])) continue;
        auto region = makeRegion(seed);
        const auto take = [&](std::size_t pixel) {
            made.label.values[pixel] = made.count;
            region.add(pixel);
            front.push_back(pixel);
        };
        take(seed);
        for (std::size_t next = 0; next < front.size(); ++next) {
            const std::size_t from = front[next];
            eachNeighbour(depth, from, [&](std::size_t pixel, std::size_t opposite, std::size_t beyond) {
                if (made.label.values[pixel] != Segments::nothing || !std::isfinite(depth.values[pixel]))
                    return;
                if (region.joins(pixel, from, opposite, beyond)) take(pixel);
            });
        }
        front.clear();
        ++made.count;
    }
    return made;
}

struct GreyRegion {
    const std::vector<float>& grey;
    double most, sum = 0.0, count = 0.0;

    bool joins(std::size_t pixel, std::size_t, std::size_t, std::size_t) const {
        return std::abs(static_cast<double>(grey[pixel]) - sum / count) <= most;
    }
    void add(std::size_t pixel) {
        sum += static_cast<double>(grey[pixel]);
        count += 1.0;
    }
};

/// A direction as a vector of twice its angle; none where a surface faces the eye.
struct Direction {
    float x = 0.0F, y = 0.0F;
};

std::vector<Direction> directionsOf(const Raster<float>& angles) {
    std::vector<Direction> made(angles.values.size());
    for (std::size_t i = 0; i < made.size(); ++i) {
        const float angle = angles.values[i];
        if (angle != 0.0F) made[i] = {std::cos(2.0F * angle), std::sin(2.0F * angle)};
    }
    return made;
}

struct AngleRegion {
    const std::vector<Direction>& directions;
    double leastCosine, x = 0.0, y = 0.0;

    bool joins(std::size_t pixel, std::size_t, std::size_t, std::size_t) const {
        const auto& one = directions[pixel];
        const double length = std::hypot(x, y);
        if (length == 0.0 || (one.x == 0.0F && one.y == 0.0F)) return true;
        return x * static_cast<double>(one.x) + y * static_cast<double>(one.y) >= leastCosine * length;
    }
    void add(std::size_t pixel) {
        x += static_cast<double>(directions[pixel].x);
        y += static_cast<double>(directions[pixel].y);
    }
};

struct DepthRegion {
    const std::vector<float>& depth;
    float most;

    bool joins(std::size_t pixel, std::size_t from, std::size_t opposite, std::size_t beyond) const {
        const float step = depth[pixel] - depth[from];
        if (std::abs(step) <= most) return true;
        return (opposite != from && goesOn(step, depth[from] - depth[opposite])) ||
               (beyond != pixel && goesOn(step, depth[beyond] - depth[pixel]));
    }
    /// On either side of a step: at a picture's side, and beside nothing, a slope is told by one of them.
    bool goesOn(float step, float slope) const {
        return std::isfinite(slope) && std::abs(step - slope) <= most;
    }
    void add(std::size_t) const {}
};

/// What regions are like.
struct RegionMeans {
    std::vector<double> pixels, grey, x, y, depth;

    RegionMeans(const Segments& segments, const Modalities& modalities,
                const std::vector<Direction>& directions)
        : pixels(segments.count),
          grey(segments.count),
          x(segments.count),
          y(segments.count),
          depth(segments.count) {
        for (std::size_t i = 0; i < directions.size(); ++i) {
            const auto label = segments.label.values[i];
            if (label == Segments::nothing) continue;
            pixels[label] += 1.0;
            grey[label] += static_cast<double>(modalities.grey.values[i]);
            x[label] += static_cast<double>(directions[i].x);
            y[label] += static_cast<double>(directions[i].y);
            depth[label] += static_cast<double>(modalities.depth.values[i]);
        }
        for (std::size_t label = 0; label < pixels.size(); ++label) {
            for (auto* const sum : {&grey, &x, &y, &depth}) (*sum)[label] /= std::max(pixels[label], 1.0);
            depth[label] /= modalities.extent;
        }
    }
    /// How little two regions are alike. Depth counts most: what lies apart is not one.
    double difference(std::uint32_t a, std::uint32_t b) const {
        return std::abs(grey[a] - grey[b]) + 0.25 * std::hypot(x[a] - x[b], y[a] - y[b]) +
               10.0 * std::abs(depth[a] - depth[b]);
    }
};

/// Labels that become one.
class Merges {
  public:
    explicit Merges(std::uint32_t count) : parents_(count) {
        std::iota(parents_.begin(), parents_.end(), 0U);
    }
    std::uint32_t root(std::uint32_t label) {
        while (parents_[label] != label) label = parents_[label] = parents_[parents_[label]];
        return label;
    }
    void merge(std::uint32_t a, std::uint32_t b) {
        a = root(a);
        b = root(b);
        parents_[std::max(a, b)] = std::min(a, b);
    }

  private:
    std::vector<std::uint32_t> parents_;
};

/// Of each region that is too small the neighbour that is most like it; `nothing` of others.
std::vector<std::uint32_t> nearestOfSmall(const Segments& segments, const RegionMeans& means,
                                          double leastPixels) {
    std::vector<std::uint32_t> nearest(segments.count, Segments::nothing);
    std::vector<double> least(segments.count, HUGE_VAL);
    const auto meet = [&](std::uint32_t a, std::uint32_t b) {
        if (means.pixels[a] >= leastPixels) return;
        const double difference = means.difference(a, b);
        if (difference > least[a] || (difference == least[a] && b >= nearest[a])) return;
        least[a] = difference;
        nearest[a] = b;
    };
    const auto& labels = segments.label;
    const auto meetBoth = [&](std::size_t i, std::size_t k) {
        const auto a = labels.values[i], b = labels.values[k];
        if (a == b || a == Segments::nothing || b == Segments::nothing) return;
        meet(a, b);
        meet(b, a);
    };
    for (std::size_t i = 0; i < labels.values.size(); ++i) {
        if (i % labels.width + 1 < labels.width) meetBoth(i, i + 1);
        if (i + labels.width < labels.values.size()) meetBoth(i, i + labels.width);
    }
    return nearest;
}

/// Labels from 0 on, in the order of their first pixels.
void renumber(Segments& segments, Merges& merges) {
    std::vector<std::uint32_t> numbers(segments.count, Segments::nothing);
    std::uint32_t count = 0;
    for (auto& label : segments.label.values) {
        if (label == Segments::nothing) continue;
        auto& number = numbers[merges.root(label)];
        if (number == Segments::nothing) number = count++;
        label = number;
    }
    segments.count = count;
}

}  // namespace

Segments growGrey(const Modalities& modalities, double most) {
    return grow(modalities, [&](std::size_t) { return GreyRegion{modalities.grey.values, most}; });
}

Segments growAngle(const Modalities& modalities, double most) {
    const auto directions = directionsOf(modalities.angle);
    return grow(modalities, [&](std::size_t) { return AngleRegion{directions, std::cos(2.0 * most)}; });
}

Segments growDepth(const Modalities& modalities, double most) {
    const auto step = static_cast<float>(most * modalities.extent);
    return grow(modalities, [&](std::size_t) { return DepthRegion{modalities.depth.values, step}; });
}

Segments intersected(const Segments& a, const Segments& b, const Segments& c) {
    Segments made{Raster<std::uint32_t>(a.label.width, a.label.height, Segments::nothing), 0};
    Merges merges(static_cast<std::uint32_t>(a.label.values.size()));
    const auto same = [&](std::size_t i, std::size_t k) {
        return a.label.values[i] == a.label.values[k] && b.label.values[i] == b.label.values[k] &&
               c.label.values[i] == c.label.values[k];
    };
    const std::size_t width = a.label.width;
    for (std::size_t i = 0; i < a.label.values.size(); ++i) {
        if (a.label.values[i] == Segments::nothing) continue;
        made.label.values[i] = static_cast<std::uint32_t>(i);
        if (i % width > 0 && same(i, i - 1))
            merges.merge(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i - 1));
        if (i >= width && same(i, i - width))
            merges.merge(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i - width));
    }
    made.count = static_cast<std::uint32_t>(a.label.values.size());
    renumber(made, merges);
    return made;
}

Segments withoutSmall(Segments segments, const Modalities& modalities, std::size_t leastPixels) {
    const auto directions = directionsOf(modalities.angle);
    // Each round halves how many small ones there are, at least.
    for (bool merged = true; merged;) {
        const RegionMeans means(segments, modalities, directions);
        const auto nearest = nearestOfSmall(segments, means, static_cast<double>(leastPixels));
        Merges merges(segments.count);
        merged = false;
        for (std::uint32_t label = 0; label < segments.count; ++label) {
            if (nearest[label] == Segments::nothing) continue;
            merges.merge(label, nearest[label]);
            merged = true;
        }
        if (merged) renumber(segments, merges);
    }
    return segments;
}

Segments segmentsOf(const Modalities& modalities, const SegmentOptions& options,
                    const std::stop_token& stop) {
    Segments grey, angle, depth;
    tbb::parallel_invoke([&] { grey = growGrey(modalities, options.grey); },
                         [&] { angle = growAngle(modalities, options.angle); },
                         [&] { depth = growDepth(modalities, options.depth); });
    if (stop.stop_requested()) return depth;
    return withoutSmall(intersected(grey, angle, depth), modalities, options.leastPixels);
}

}  // namespace mote::render
