// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/pixel_map.h"

#include <algorithm>
#include <cmath>

#include "protocol/base/mote_check.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/long_list.h"

namespace mote::render {

PixelMap::PixelMap(std::uint32_t width, std::uint32_t height, std::vector<float> values)
    : width_(width), height_(height), values_(std::move(values)) {
    MOTE_CHECK(width_ > 0 && height_ > 0 && values_.size() == std::size_t{width_} * height_);
    const std::size_t stride = std::size_t{width_} + 1;
    resizeInTurns(sums_, stride * (std::size_t{height_} + 1));
    using Range = tbb::blocked_range<std::size_t>;
    forRangesInTurns(height_, 64, [&](const Range& rows) {
        for (auto y = rows.begin(); y != rows.end(); ++y) {
            double sum = 0.0;
            double* to = &sums_[(y + 1) * stride];
            for (std::size_t x = 0; x < width_; ++x) to[x + 1] = sum += values_[y * width_ + x];
        }
    });
    forRangesInTurns(width_, 256, [&](const Range& columns) {
        for (std::size_t y = 1; y <= height_; ++y) {
            const double* above = &sums_[(y - 1) * stride];
            double* to = &sums_[y * stride];
            for (auto x = columns.begin(); x != columns.end(); ++x) to[x + 1] += above[x + 1];
        }
    });
}

/// The sum of all above y and to the left of x, linear within pixels.
double PixelMap::sum(double x, double y) const {
    const auto column = std::min(static_cast<std::size_t>(x), std::size_t{width_} - 1);
    const auto row = std::min(static_cast<std::size_t>(y), std::size_t{height_} - 1);
    const double u = x - static_cast<double>(column);
    const double v = y - static_cast<double>(row);
    const double* above = &sums_[row * (std::size_t{width_} + 1) + column];
    const double* below = above + width_ + 1;
    return (above[0] * (1 - u) + above[1] * u) * (1 - v) + (below[0] * (1 - u) + below[1] * u) * v;
}

double PixelMap::mean(double x, double y, double side) const {
    const double half = 0.5 * std::max(side, 1.0);
    const double right = width_;
    const double bottom = height_;
    x = std::clamp(x, 0.0, right);
    y = std::clamp(y, 0.0, bottom);
    const double x0 = std::max(x - half, 0.0);
    const double x1 = std::min(x + half, right);
    const double y0 = std::max(y - half, 0.0);
    const double y1 = std::min(y + half, bottom);
    const double inside = sum(x1, y1) - sum(x0, y1) - sum(x1, y0) + sum(x0, y0);
    return std::max(inside, 0.0) / ((x1 - x0) * (y1 - y0));
}

}  // namespace mote::render
