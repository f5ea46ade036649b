// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/line_crossings.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "server/render/ink/tone_grid.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr double square = 4.0;  // pixels
// Lines in a square: where there are more, each is shorter than what is told apart, and none is compared.
constexpr std::uint32_t crowd = 4096;

double area(const glm::dvec2& a, const glm::dvec2& b) {
    return a.x * b.y - a.y * b.x;
}

/// The share of a line at which a nearer one crosses it; below 0 where none does.
double crossing(const ScreenLine& line, const ScreenLine& other) {
    const glm::dvec2 way = line.to - line.from, otherWay = other.to - other.from,
                     off = other.from - line.from;
    const double turn = area(way, otherWay);
    if (turn == 0.0) return -1.0;
    const double share = area(off, otherWay) / turn, otherShare = area(off, way) / turn;
    if (!(share > 0.0 && share < 1.0 && otherShare >= 0.0 && otherShare <= 1.0)) return -1.0;
    const double here = std::lerp(line.nearnessFrom, line.nearnessTo, share);
    const double there = std::lerp(other.nearnessFrom, other.nearnessTo, otherShare);
    return there > here ? share : -1.0;
}

}  // namespace

LineCrossings::LineCrossings(std::vector<ScreenLine> lines, std::uint32_t width, std::uint32_t height,
                             double margin, const std::stop_token& stop)
    : lines_(std::move(lines)),
      margin_(margin),
      columns_(static_cast<std::uint32_t>(std::ceil((width + 2.0 * margin) / square))),
      rows_(static_cast<std::uint32_t>(std::ceil((height + 2.0 * margin) / square))),
      begins_(std::size_t{columns_} * rows_ + 1, 0) {
    const auto eachPlace = [&](const auto& take) {
        for (std::uint32_t i = 0; i < lines_.size() && !isStopped(stop); ++i) {
            const ScreenLine line = onGrid(lines_[i]);
            eachSquare(line.from, line.to, columns_, rows_,
                       [&](std::uint32_t column, std::uint32_t row, double) {
                           take(std::size_t{row} * columns_ + column, i);
                       });
        }
    };
    eachPlace([&](std::size_t at, std::uint32_t) { ++begins_[at + 1]; });
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    inside_.resize(begins_.back());
    auto next = begins_;
    eachPlace([&](std::size_t at, std::uint32_t i) {
        if (next[at] < begins_[at + 1]) inside_[next[at]++] = i;
    });
}

ScreenLine LineCrossings::onGrid(const ScreenLine& line) const {
    return {(line.from + margin_) / square, (line.to + margin_) / square, 0.0, 0.0};
}

void LineCrossings::along(const ScreenLine& line, std::vector<double>& shares) const {
    shares.clear();
    const ScreenLine placed = onGrid(line);
    eachSquare(placed.from, placed.to, columns_, rows_, [&](std::uint32_t column, std::uint32_t row, double) {
        const std::size_t at = std::size_t{row} * columns_ + column;
        if (begins_[at + 1] - begins_[at] > crowd) return;
        for (auto i = begins_[at]; i < begins_[at + 1]; ++i) {
            const double share = crossing(line, lines_[inside_[i]]);
            if (share >= 0.0) shares.push_back(share);
        }
    });
    std::sort(shares.begin(), shares.end());
}

}  // namespace mote::render
