// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/carry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>

#include "server/render/ink/tone_grid.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr double square = 4.0;       // pixels
constexpr double reach = 1.5;        // pixels between a line and itself
constexpr double otherKind = 0.3;    // what another kind counts beside the squares of these
constexpr double shortPart = 0.75;   // pixels of a line of which one place tells enough
constexpr double leastCosine = 0.8;  // cosine of what it turns by

constexpr std::uint32_t nowhere = UINT32_MAX;
constexpr double alikeDepth = 0.01;     // of the extent: what is one place in two pictures differs by less
constexpr double alikeLine = 0.004;     // likewise of lines, which lie in crowds
constexpr double carriedEvery = 4.0;    // pixels between places of a hatch that go with the surface
constexpr float kept = 0.85F;           // of the density before
constexpr std::array around{0, -1, 1};  // pixels beside that in which a place was

/// Calls take(pixel) for those of a picture at a place and around it, until it says true.
template <class T, class Take>
void eachAround(const Raster<T>& picture, const glm::dvec2& at, const Take& take) {
    if (!(at.x >= 0.0 && at.y >= 0.0 && at.x < picture.width && at.y < picture.height)) return;
    for (const int down : around) {
        for (const int across : around) {
            const auto column = static_cast<std::int64_t>(at.x) + across;
            const auto row = static_cast<std::int64_t>(at.y) + down;
            if (column < 0 || row < 0 || column >= picture.width || row >= picture.height) continue;
            if (take(picture.index(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row))))
                return;
        }
    }
}

Raster<std::uint32_t> seenBefore(const Modalities& now, const PictureMotion& motion,
                                 const InkMemory& before) {
    const auto& depth = now.depth;
    Raster<std::uint32_t> from(depth.width, depth.height, nowhere);
    const double most = alikeDepth * before.extent;
    forInTurns(std::uint32_t{0}, depth.height, [&](std::uint32_t row) {
        for (std::uint32_t column = 0; column < depth.width; ++column) {
            const auto here = static_cast<double>(depth.at(column, row));
            if (!std::isfinite(here)) continue;
            const auto was = motion({{column + 0.5, row + 0.5}, here});
            eachAround(before.depth, was.at, [&](std::size_t pixel) {
                if (!(std::abs(static_cast<double>(before.depth.values[pixel]) - was.depth) <= most))
                    return false;
                from.at(column, row) = static_cast<std::uint32_t>(pixel);
                return true;
            });
        }
    });
    return from;
}

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
                    {a.at, b.at, static_cast<float>(a.depth), static_cast<float>(b.depth), state, line.kind});
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

LineBefore LineMap::at(const PicturePlace& place, const glm::dvec2& direction, LineKind kind,
                       double alike) const {
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
        const double difference =
            off * off + std::pow((depth - place.depth) / alike, 2.0) + (kind == part.kind ? 0.0 : otherKind);
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

Carry::Carry(const Modalities& now, const InkCamera& camera, const InkMemory& before)
    : now_(now),
      before_(before),
      motion_(camera, before.camera),
      forward_(before.camera, camera),
      lines_(before.drawn, before.left, before.depth.width, before.depth.height),
      from_(seenBefore(now, motion_, before)) {}

LineBefore Carry::segmentBefore(const LinePoint& from, const LinePoint& to, LineKind kind) const {
    const auto a = motion_({from.at, from.depth}), b = motion_({to.at, to.depth});
    const double length = glm::distance(a.at, b.at);
    if (!std::isfinite(length)) return LineBefore::unknown;
    const glm::dvec2 direction = length > 0.0 ? (b.at - a.at) / length : glm::dvec2(0.0);
    const auto at = [&](double share) {
        const PicturePlace place{glm::mix(a.at, b.at, share), std::lerp(a.depth, b.depth, share)};
        return lines_.at(place, direction, kind, alikeLine * before_.extent);
    };
    if (length <= shortPart) return at(0.5);
    std::array<int, 3> counts{};
    for (const double share : {1.0 / 6.0, 0.5, 5.0 / 6.0}) ++counts[static_cast<std::size_t>(at(share))];
    return static_cast<LineBefore>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

std::vector<std::vector<LineBefore>> Carry::linesBefore(const std::vector<InkLine>& lines) const {
    std::vector<std::vector<LineBefore>> states(lines.size());
    forInTurns(std::size_t{0}, lines.size(), [&](std::size_t i) {
        const auto& points = lines[i].points;
        for (std::size_t k = 0; k + 1 < points.size(); ++k)
            states[i].push_back(segmentBefore(points[k], points[k + 1], lines[i].kind));
    });
    return states;
}

std::vector<HatchStroke> Carry::hatches() const {
    std::vector<HatchStroke> made;
    const double most = alikeDepth * now_.extent;
    const auto& depth = before_.depth;
    for (const auto& stroke : before_.hatches) {
        giveWay();
        HatchStroke moved{{}, stroke.pass, stroke.second};
        const auto end = [&] {
            if (moved.points.size() > 1) made.push_back(moved);
            moved.points.clear();
        };
        for (std::size_t i = 0; i < stroke.points.size(); ++i) {
            // Long parts are straight, but the surface below need not be.
            const glm::dvec2 from = stroke.points[i],
                             to = stroke.points[std::min(i + 1, stroke.points.size() - 1)];
            const auto parts =
                static_cast<int>(std::clamp(std::ceil(glm::distance(from, to) / carriedEvery), 1.0, 4096.0));
            for (int part = 0; part < parts; ++part) {
                const glm::dvec2 at = glm::mix(from, to, static_cast<double>(part) / parts);
                const auto place = forward_({at, static_cast<double>(depth.near(at.x, at.y))});
                bool seen = false;
                if (std::isfinite(place.depth))
                    eachAround(now_.depth, place.at, [&](std::size_t pixel) {
                        return seen = std::abs(static_cast<double>(now_.depth.values[pixel]) - place.depth) <=
                                      most;
                    });
                if (seen)
                    moved.points.push_back(place.at);
                else
                    end();
            }
        }
        end();
    }
    return made;
}

void Carry::even(Raster<float>& density) const {
    if (before_.density.values.empty()) return;
    for (std::size_t i = 0; i < density.values.size(); ++i) {
        if (from_.values[i] == nowhere) continue;
        density.values[i] += kept * (before_.density.values[from_.values[i]] - density.values[i]);
    }
}

}  // namespace mote::render
