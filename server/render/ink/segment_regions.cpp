// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/segment_regions.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "server/render/ink/modalities.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/long_list.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr std::size_t leastInside = 4;  // by so much fewer pixels need be inside: thin ones are small

/// take(pixel) for all of them, but not for long once it is to stop.
template <class Take>
void eachPixel(const Raster<std::uint32_t>& picture, const std::stop_token& stop, const Take& take) {
    for (std::uint32_t row = 0; row < picture.height && !isStopped(stop); ++row) {
        const std::size_t first = picture.index(0, row);
        for (std::size_t i = first; i < first + picture.width; ++i) take(i);
    }
}

/// What a region is like: means over its pixels.
struct RegionMean {
    std::uint32_t pixels = 0, inside = 0;  // those with their region all around
    float grey = 0.0F, x = 0.0F, y = 0.0F;
    double depth = 0.0;

    void add(float oneGrey, const Direction& direction, double oneDepth) {
        ++pixels;
        const float share = 1.0F / static_cast<float>(pixels);
        grey += share * (oneGrey - grey);
        x += share * (direction.x - x);
        y += share * (direction.y - y);
        depth += (oneDepth - depth) / pixels;
    }
};

/// Whether no pixel beside this one is of another region.
bool isInside(const Raster<std::uint32_t>& label, std::size_t i) {
    const std::size_t width = label.width, column = i % width;
    const auto same = [&](std::size_t other) { return label.values[other] == label.values[i]; };
    return (column == 0 || same(i - 1)) && (column + 1 == width || same(i + 1)) &&
           (i < width || same(i - width)) && (i + width >= label.values.size() || same(i + width));
}

std::vector<RegionMean> meansOf(const Segments& segments, const Modalities& modalities,
                                const std::vector<Direction>& directions, const std::stop_token& stop) {
    std::vector<RegionMean> means(segments.count);
    eachPixel(segments.label, stop, [&](std::size_t i) {
        const auto label = segments.label.values[i];
        if (label == Segments::nothing) return;
        means[label].add(modalities.grey.values[i], directions[i],
                         static_cast<double>(modalities.depth.values[i]) / modalities.extent);
        if (isInside(segments.label, i)) ++means[label].inside;
    });
    return means;
}

/// How little two regions are alike. Depth counts most: what lies apart is not one.
float difference(const RegionMean& a, const RegionMean& b) {
    return std::abs(a.grey - b.grey) + 0.25F * std::hypot(a.x - b.x, a.y - b.y) +
           static_cast<float>(10.0 * std::abs(a.depth - b.depth));
}

/// A neighbour that a region may become part of; the least is the best. Beside each other in one part they
/// come before all others.
struct Neighbour {
    bool crosses = true;
    float difference = HUGE_VALF;
    std::uint32_t label = Segments::nothing;

    bool operator<(const Neighbour& other) const {
        return std::tie(crosses, difference, label) < std::tie(other.crosses, other.difference, other.label);
    }
};

/// The neighbour that is most like it, of each region that is too small; `nothing` of others.
std::vector<Neighbour> nearestOfSmall(const Segments& segments, const Raster<std::uint32_t>& part,
                                      const std::vector<RegionMean>& means, std::size_t leastPixels,
                                      const std::stop_token& stop) {
    std::vector<Neighbour> nearest(segments.count);
    const auto meet = [&](std::uint32_t a, std::uint32_t b, bool crosses) {
        if (means[a].pixels >= leastPixels && means[a].inside >= leastPixels / leastInside) return;
        const float apart = difference(means[a], means[b]);
        const Neighbour one{crosses, std::isfinite(apart) ? apart : HUGE_VALF, b};
        if (one < nearest[a]) nearest[a] = one;
    };
    const auto& labels = segments.label;
    const auto meetBoth = [&](std::size_t i, std::size_t k) {
        const auto a = labels.values[i], b = labels.values[k];
        if (a == b || a == Segments::nothing || b == Segments::nothing) return;
        const bool crosses = part.values[i] != part.values[k];
        meet(a, b, crosses);
        meet(b, a, crosses);
    };
    eachPixel(labels, stop, [&](std::size_t i) {
        if (i % labels.width + 1 < labels.width) meetBoth(i, i + 1);
        if (i + labels.width < labels.values.size()) meetBoth(i, i + labels.width);
    });
    return nearest;
}

}  // namespace

std::vector<Direction> directionsOf(const Raster<float>& angles, const std::stop_token& stop) {
    auto made = listInTurns<Direction>(angles.values.size());
    forInTurns(std::uint32_t{0}, angles.height, [&](std::uint32_t row) {
        if (isStopped(stop)) return;
        const std::size_t first = angles.index(0, row);
        for (std::size_t i = first; i < first + angles.width; ++i) made[i] = directionOf(angles.values[i]);
    });
    return made;
}

void renumber(Segments& segments, Merges& merges, const std::stop_token& stop) {
    if (isStopped(stop)) return;
    auto numbers = listInTurns(segments.count, Segments::nothing);
    std::uint32_t count = 0;
    eachPixel(segments.label, stop, [&](std::size_t i) {
        auto& label = segments.label.values[i];
        if (label == Segments::nothing) return;
        auto& number = numbers[merges.root(label)];
        if (number == Segments::nothing) number = count++;
        label = number;
    });
    segments.count = count;
}

Segments intersected(const Segments& a, const Segments& b, const Segments& c, const std::stop_token& stop) {
    const auto pixels = static_cast<std::uint32_t>(a.label.values.size());
    Segments made{Raster<std::uint32_t>(a.label.width, a.label.height, Segments::nothing), pixels};
    if (isStopped(stop)) return made;
    Merges merges(pixels);
    const auto same = [&](std::size_t i, std::size_t k) {
        return a.label.values[i] == a.label.values[k] && b.label.values[i] == b.label.values[k] &&
               c.label.values[i] == c.label.values[k];
    };
    const std::size_t width = a.label.width;
    eachPixel(a.label, stop, [&](std::size_t i) {
        if (a.label.values[i] == Segments::nothing) return;
        const auto own = static_cast<std::uint32_t>(i);
        made.label.values[i] = own;
        if (i % width > 0 && same(i, i - 1)) merges.merge(own, own - 1U);
        if (i >= width && same(i, i - width)) merges.merge(own, static_cast<std::uint32_t>(i - width));
    });
    renumber(made, merges, stop);
    return made;
}

Segments withoutSmall(Segments segments, const Modalities& modalities, std::size_t leastPixels,
                      const std::stop_token& stop) {
    if (isStopped(stop)) return segments;
    const auto directions = directionsOf(modalities.angle, stop);
    // Each round halves how many small ones there are, at least.
    for (bool merged = true; merged && !isStopped(stop);) {
        const auto means = meansOf(segments, modalities, directions, stop);
        const auto nearest = nearestOfSmall(segments, modalities.part, means, leastPixels, stop);
        Merges merges(segments.count);
        merged = false;
        for (std::uint32_t label = 0; label < segments.count; ++label) {
            if (nearest[label].label == Segments::nothing) continue;
            merges.merge(label, nearest[label].label);
            merged = true;
        }
        if (merged) renumber(segments, merges, stop);
    }
    return segments;
}

}  // namespace mote::render
