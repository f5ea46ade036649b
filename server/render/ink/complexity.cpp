// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/complexity.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "server/render/ink/tone_grid.h"

namespace mote::render {
namespace {

constexpr double farStep = 0.05;  // of the extent: neighbours in depth are nearer
constexpr int passes = 3;

constexpr std::uint32_t beside = 16;  // columns that are passed at once: a line of the cache

/// Blurs lines of `count` pixels, a stride apart, there and back, with `keep` of what came so far at each
/// pixel that is connected; as many lines as there are `lines`, side by side.
struct Pass {
    std::size_t count, stride, lines;
    float keep, step;

    void over(float* values, const float* depth) const {
        for (std::size_t i = 1; i < count; ++i) blend(values, depth, (i - 1) * stride, i * stride);
        for (std::size_t i = count - 1; i > 0; --i) blend(values, depth, i * stride, (i - 1) * stride);
    }
    void blend(float* values, const float* depth, std::size_t from, std::size_t to) const {
        for (std::size_t line = 0; line < lines; ++line, ++from, ++to) {
            if (depth[from] == depth[to] || std::abs(depth[from] - depth[to]) <= step)
                values[to] += keep * (values[from] - values[to]);
        }
    }
};

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
        const Pass along{made.width, 1, 1, keep, step};
        tbb::parallel_for(std::uint32_t{0}, made.height, [&](std::uint32_t row) {
            if (stop.stop_requested()) return;
            const auto first = made.index(0, row);
            along.over(&made.values[first], &depth.values[first]);
        });
        tbb::parallel_for(std::uint32_t{0}, (made.width + beside - 1) / beside, [&](std::uint32_t block) {
            if (stop.stop_requested()) return;
            const std::uint32_t column = block * beside;
            const Pass down{made.height, made.width, std::min(beside, made.width - column), keep, step};
            down.over(&made.values[column], &depth.values[column]);
        });
    }
    return made;
}

}  // namespace mote::render
