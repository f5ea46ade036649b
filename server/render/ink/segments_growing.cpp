// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/segments_growing.h"

#include <cmath>
#include <vector>

#include "server/render/ink/modalities.h"
#include "server/render/ink/region_graph.h"
#include "server/render/ink/segment_regions.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr std::size_t growthsPerStop = std::size_t{1} << 16;  // pixels

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

/// Grows one region after another, each within one part. A Region is made of its seed and says
/// joins(neighbour, from, opposite, beyond) and add(pixel).
template <class MakeRegion>
Segments grow(const Modalities& modalities, const std::stop_token& stop, const MakeRegion& makeRegion) {
    const auto& depth = modalities.depth;
    const auto& part = modalities.part.values;
    Segments made{Raster<std::uint32_t>(depth.width, depth.height, Segments::nothing), 0};
    std::vector<std::uint32_t> front;
    std::size_t taken = 0;
    for (std::size_t seed = 0; seed < depth.values.size(); ++seed) {
        if (made.label.values[seed] != Segments::nothing || !std::isfinite(depth.values[seed])) continue;
        auto region = makeRegion(seed);
        const auto take = [&](std::size_t pixel) {
            made.label.values[pixel] = made.count;
            region.add(pixel);
            front.push_back(static_cast<std::uint32_t>(pixel));
        };
        take(seed);
        for (std::size_t next = 0; next < front.size(); ++next) {
            if (++taken % growthsPerStop == 0 && isStopped(stop)) return made;
            const std::size_t from = front[next];
            eachNeighbour(depth, from, [&](std::size_t pixel, std::size_t opposite, std::size_t beyond) {
                if (made.label.values[pixel] != Segments::nothing || !std::isfinite(depth.values[pixel]) ||
                    part[pixel] != part[from])
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

}  // namespace

Segments growGrey(const Modalities& modalities, double most, const std::stop_token& stop) {
    return grow(modalities, stop, [&](std::size_t) { return GreyRegion{modalities.grey.values, most}; });
}

Segments growAngle(const Modalities& modalities, double most, const std::stop_token& stop) {
    const auto directions = directionsOf(modalities.angle, stop);
    return grow(modalities, stop, [&](std::size_t) { return AngleRegion{directions, std::cos(2.0 * most)}; });
}

Segments growDepth(const Modalities& modalities, double most, const std::stop_token& stop) {
    const auto step = static_cast<float>(most * modalities.extent);
    return grow(modalities, stop, [&](std::size_t) { return DepthRegion{modalities.depth.values, step}; });
}

Segments grownSegments(const Modalities& modalities, const GrowOptions& options, std::size_t leastPixels,
                       const std::stop_token& stop) {
    Segments grey, angle, depth;
    bothInTurns([&] { grey = growGrey(modalities, options.grey, stop); },
                [&] {
                    bothInTurns([&] { angle = growAngle(modalities, options.angle, stop); },
                                [&] { depth = growDepth(modalities, options.depth, stop); });
                });
    auto made = withoutSmall(intersected(grey, angle, depth, stop), modalities, leastPixels, stop);
    grey = angle = depth = {};
    return melted(std::move(made), modalities, stepWeights(modalities, {}, stop), options.affinity,
                  options.turn, stop);
}

}  // namespace mote::render
