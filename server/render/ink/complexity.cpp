// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/complexity.h"

#include <cmath>

#include "server/render/ink/tone_grid.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr double farStep = 0.05;  // of the extent: neighbours in depth are nearer
constexpr int passes = 3;
constexpr std::size_t columnsAtOnce = 64;

/// What comes along a way from pixel to pixel: of what came so far, so much is kept at each that is
/// connected.
class Pass {
  public:
    Pass(const float* depth, float keep, float step) : depth_(depth), keep_(keep), step_(step) {}

    void operator()(float* values, std::size_t from, std::size_t to) const {
        const bool connected = depth_[from] == depth_[to] || std::abs(depth_[from] - depth_[to]) <= step_;
        values[to] += connected ? keep_ * (values[from] - values[to]) : 0.0F;
    }

  private:
    const float* depth_;
    const float keep_, step_;
};

/// Along a row there and back.
void passRow(float* values, const Pass& pass, std::size_t first, std::size_t width) {
    for (std::size_t i = first + 1; i < first + width; ++i) pass(values, i - 1, i);
    for (std::size_t i = first + width - 1; i > first; --i) pass(values, i, i - 1);
}

/// Down some columns and back, row by row, as memory lies.
void passColumns(float* values, const Pass& pass, const tbb::blocked_range<std::size_t>& columns,
                 std::size_t width, std::size_t height) {
    for (std::size_t row = 1; row < height; ++row) {
        for (std::size_t i = row * width + columns.begin(); i < row * width + columns.end(); ++i)
            pass(values, i - width, i);
    }
    for (std::size_t row = height - 1; row > 0; --row) {
        for (std::size_t i = row * width + columns.begin(); i < row * width + columns.end(); ++i)
            pass(values, i, i - width);
    }
}

}  // namespace

Raster<float> coverOf(const std::vector<InkLine>& lines, std::uint32_t columns, std::uint32_t rows,
                      double width) {
    Raster<float> cover(columns, rows);
    for (const auto& line : lines) {
        giveWay();
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
    auto made = picture.copy();
    const auto step = static_cast<float>(farStep * extent);
    for (int pass = 0; pass < passes; ++pass) {
        const double share =
            std::sqrt(3.0) * std::pow(2.0, passes - pass - 1) / std::sqrt(std::pow(4.0, passes) - 1.0);
        const auto keep = static_cast<float>(std::exp(-std::sqrt(2.0) / (deviation * share)));
        const Pass along(depth.values.data(), keep, step);
        forInTurns(std::uint32_t{0}, made.height, [&](std::uint32_t row) {
            if (isStopped(stop)) return;
            passRow(made.values.data(), along, made.index(0, row), made.width);
        });
        forRangesInTurns(made.width, columnsAtOnce, [&](const auto& columns) {
            if (!isStopped(stop)) passColumns(made.values.data(), along, columns, made.width, made.height);
        });
    }
    return made;
}

}  // namespace mote::render
