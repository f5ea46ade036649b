// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/line_map.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

#include "server/render/ink/tone_grid.h"

namespace mote::render {
namespace {

constexpr double square = 4.0;       // pixels
constexpr double reach = 1.5;        // pixels between a line and itself
constexpr double leastCosine = 0.8;  // cosine of what it turns by

}  // namespace

template <class Take>
void LineMap::eachPart(const Take& take) const {
    for (std::uint32_t i = 0; i < parts_.size(); ++i) {
        const glm::dvec2 from(parts_[i].from), to(parts_[i].to);
        eachSquare(from / square, to / square, columns_, rows_,
                   [&](std::uint32_t column, std::uint32_t row, double) {
                       take(std::size_t{row} * columns_ + column, i);
                   });
    }
}

LineMap::LineMap(const std::vector<InkLine>& drawn, const std::vector<InkLine>& left, std::uint32_t width,
                 std::uint32_t height)
    : columns_(static_cast<std::uint32_t>(std::ceil(width / square))),
      rows_(static_cast<std::uint32_t>(std::ceil(height / square))),
      begins_(std::size_t{columns_} * rows_ + 1, 0) {
    const auto add = [&](const std::vector<InkLine>& lines, LineBefore state) {
        for (const auto& line : lines) {
            for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
                const auto &a = line.points[i], &b = line.points[i + 1];
                parts_.push_back(
                    {a.at, b.at, static_cast<float>(a.depth), static_cast<float>(b.depth), state});
            }
        }
    };
    add(drawn, LineBefore::drawn);
    add(left, LineBefore::left);
    eachPart([&](std::size_t at, std::uint32_t) { ++begins_[at + 1]; });
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    inside_.resize(begins_.back());
    auto next = begins_;
    eachPart([&](std::size_t at, std::uint32_t i) { inside_[next[at]++] = i; });
}

LineBefore LineMap::at(const PicturePlace& place, const glm::dvec2& direction, double alike) const {
    auto state = LineBefore::unknown;
    double least = 1.0;
    const auto compare = [&](const Part& part) {
        const glm::dvec2 from(part.from), way = glm::dvec2(part.to) - from;
        const double length = glm::length(way);
        if (!(std::abs(glm::dot(way, direction)) >= leastCosine * length)) return;
        const double share =
            length > 0.0 ? std::clamp(glm::dot(place.at - from, way) / (length * length), 0.0, 1.0) : 0.0;
        const double off = glm::distance(place.at, from + share * way) / reach;
        const double depth =
            std::lerp(static_cast<double>(part.depthFrom), static_cast<double>(part.depthTo), share);
        const double difference = off * off + std::pow((depth - place.depth) / alike, 2.0);
        if (!(difference < least)) return;
        least = difference;
        state = part.state;
    };
    const auto held = [](double at, std::uint32_t count) {
        return static_cast<std::uint32_t>(std::clamp(std::floor(at / square), 0.0, count - 1.0));
    };
    if (columns_ == 0 || rows_ == 0) return state;
    for (auto row = held(place.at.y - reach, rows_); row <= held(place.at.y + reach, rows_); ++row) {
        for (auto column = held(place.at.x - reach, columns_); column <= held(place.at.x + reach, columns_);
             ++column) {
            const std::size_t at = std::size_t{row} * columns_ + column;
            for (auto i = begins_[at]; i < begins_[at + 1]; ++i) compare(parts_[inside_[i]]);
        }
    }
    return state;
}

}  // namespace mote::render
