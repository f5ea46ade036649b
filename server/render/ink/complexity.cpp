// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/complexity.h"

#include <tbb/parallel_for.h>

#include <cmath>

#include "server/render/ink/tone_grid.h"

namespace mote::render {
namespace {

constexpr double farStep = 0.05;  // of the extent: neighbours in depth are nearer
constexpr int passes = 3;

/// Along one axis there and back, with `keep` of what came so far at each pixel that is connected.
void passLine(float* values, const float* depth, std::size_t count, std::size_t stride, float keep,
              float step) {
    const auto connected = [&](std::size_t a, std::size_t b) {
        return depth[a * stride] == depth[b * stride] ||
               std::abs(depth[a * stride] - depth[b * stride]) <= step;
    };
    for (std::size_t i = 1; i < count; ++i) {
        if (connected(i - 1, i)) values[i * stride] += keep * (values[(i - 1) * stride] - values[i * stride]);
    }
    for (std::size_t i = count - 1; i > 0; --i) {
        if (connected(i - 1, i))
            values[(i - 1) * stride] += keep * (values[i * stride] - values[(i - 1) * stride]);
    }
}

}  // namespace

Raster<float> coverOf(const std::vector<InkLine>& lines, std::uint32_t columns, std::uint32_t rows,
                      double width) {
    Raster<float> cover(columns, rows);
    for (const auto& line : lines) {
        for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
            eachSquare(line.points[i].at, line.points[i + 1].at, columns, rows,
                       [&](std::uint32_t column, std::uint32_t row, double length) {
                           cover.at(column, row) += static_cast<float>(width * length);
                       });
        }
    }
    return cover;
}

Raster<float> blurredWithin(const Raster<float>& picture, const Raster<float>& depth, double extent,
                            double deviation, const std::stop_token& stop) {
    Raster<float> made = picture;
    const auto step = static_cast<float>(farStep * extent);
    for (int pass = 0; pass < passes; ++pass) {
        const double share =
            std::sqrt(3.0) * std::pow(2.0, passes - pass - 1) / std::sqrt(std::pow(4.0, passes) - 1.0);
        const auto keep = static_cast<float>(std::exp(-std::sqrt(2.0) / (deviation * share)));
        tbb::parallel_for(std::uint32_t{0}, made.height, [&](std::uint32_t row) {
            if (stop.stop_requested()) return;
            const auto first = made.index(0, row);
            passLine(&made.values[first], &depth.values[first], made.width, 1, keep, step);
        });
        tbb::parallel_for(std::uint32_t{0}, made.width, [&](std::uint32_t column) {
            if (stop.stop_requested()) return;
            passLine(&made.values[column], &depth.values[column], made.height, made.width, keep, step);
        });
    }
    return made;
}

}  // namespace mote::render
