// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/pen.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr double depthEvery = 2.0;    // pixels along a stroke between the places where its depth is taken
constexpr double mostPlaces = 16384;  // along one straight part
// Of the extent: ink lies so much in front of the surface.
constexpr double nearer = 1e-3;
// Of the extent: beside a hatch the surface is not nearer by more, or it is another one.
constexpr double mostSlope = 0.01;
// Of the extent: so much nearer a surface may bulge within a pixel of its silhouette.
constexpr double mostBulge = 0.15;
constexpr std::size_t depthsPerStop = 65536;  // pixels whose depth is spread
constexpr double handEvery = 5.0;             // pixels between places of a stroke that a hand moves
constexpr double wave = 24.0;                 // pixels between the places where a hand leaves its way anew
constexpr double mostTapered = 20.0;          // pixels at each end
constexpr double thinnest = 0.25;             // of the width, at the end

/// A number from 0 to 1 that belongs to a stroke and a place on it, and changes with no other stroke.
double noise(std::uint64_t stroke, std::uint64_t place) {
    std::uint64_t mixed = stroke + 0x9E3779B97F4A7C15U * (place + 1);
    mixed = (mixed ^ (mixed >> 30U)) * 0xBF58476D1CE4E5B9U;
    mixed = (mixed ^ (mixed >> 27U)) * 0x94D049BB133111EBU;
    return static_cast<double>((mixed ^ (mixed >> 31U)) >> 11U) * 0x1p-53;
}

/// Where it begins tells a stroke from others, by whole pixels: a little motion does not change its hand.
std::uint64_t seedOf(const glm::dvec2& place) {
    const auto whole = [](double at) {
        return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(at)));
    };
    return whole(place.x) * 0x100000001B3U ^ whole(place.y);
}

/// In how many parts depths are taken along a way.
double partsOf(const glm::dvec2& from, const glm::dvec2& to) {
    return std::clamp(std::ceil(glm::distance(from, to) / depthEvery), 1.0, mostPlaces);
}

/// The least of a pixel and its neighbours along rows, with rows turned into columns.
Raster<float> leastAlong(const Raster<float>& picture) {
    Raster<float> turned(picture.height, picture.width);
    forInTurns(std::uint32_t{0}, picture.height, [&](std::uint32_t row) {
        for (std::uint32_t column = 0; column < picture.width; ++column) {
            const std::uint32_t left = std::max(column, 1U) - 1,
                                right = std::min(column + 1, picture.width - 1);
            turned.at(row, column) =
                std::min({picture.at(left, row), picture.at(column, row), picture.at(right, row)});
        }
    });
    return turned;
}

/// Where nothing is seen, the depth of what is seen nearest, by steps from pixel to pixel.
void spread(Raster<float>& depth, const std::stop_token& stop) {
    std::vector<std::size_t> front;
    for (std::size_t i = 0; i < depth.values.size(); ++i) {
        if (std::isfinite(depth.values[i])) front.push_back(i);
    }
    const std::size_t width = depth.width;
    for (std::size_t next = 0; next < front.size(); ++next) {
        if (next % depthsPerStop == 0 && isStopped(stop)) return;
        const std::size_t from = front[next], column = from % width;
        const auto take = [&](std::size_t pixel) {
            if (std::isfinite(depth.values[pixel])) return;
            depth.values[pixel] = depth.values[from];
            front.push_back(pixel);
        };
        if (column > 0) take(from - 1);
        if (column + 1 < width) take(from + 1);
        if (from >= width) take(from - width);
        if (from + width < depth.values.size()) take(from + width);
    }
}

}  // namespace

/// The nearest depth of the pixel at a place and those around it.
double Pen::nearestAround(const glm::dvec2& place) const {
    float nearest = HUGE_VALF;
    for (const double y : {-1.0, 0.0, 1.0}) {
        for (const double x : {-1.0, 0.0, 1.0})
            nearest = std::min(nearest, modalities_.depth.near(place.x + x, place.y + y));
    }
    return static_cast<double>(nearest);
}

Pen::Aim Pen::aimBeside(const LinePoint& line) const {
    const double nearest = nearestAround(line.at);
    const double bulge = std::clamp(line.depth - nearest, 0.0, mostBulge * modalities_.extent);
    return {line.depth - 1.25 * bulge, 0.25 * bulge};
}

Pen::Aim Pen::aimOn(const glm::dvec2& place) const {
    const double nearest = nearestAround(place);
    const auto here = static_cast<double>(modalities_.depth.near(place.x, place.y));
    if (!std::isfinite(nearest)) return {HUGE_VAL, 0.0};
    const double slope = std::min(here - nearest, mostSlope * modalities_.extent);
    return {nearest - 0.5 * slope, 0.5 * slope};
}

/// Appends a straight part without its first place: its last one, and those between at which no line from the
/// one before meets all aims (Bristol 1990, Swinging door trending).
void Pen::lay(const glm::dvec2& from, const glm::dvec2& to, double width) {
    const std::size_t last = aims_.size() - 1;
    const auto point = [&](std::size_t i) {
        return Point{glm::mix(from, to, static_cast<double>(i) / static_cast<double>(last)), aims_[i].depth,
                     width};
    };
    double least = -HUGE_VAL, most = HUGE_VAL;  // slopes from the place before
    for (std::size_t i = 1, before = 0; i <= last; ++i) {
        auto places = static_cast<double>(i - before);
        const double slope = (aims_[i].depth - aims_[before].depth) / places;
        if (slope < least || slope > most) {
            before = i - 1;
            points_.push_back(point(before));
            least = -HUGE_VAL;
            most = HUGE_VAL;
            places = 1.0;
        }
        const double off = aims_[i].depth - aims_[before].depth;
        const double tolerance = aims_[i].tolerance + 0.5 * nearer * modalities_.extent;
        least = std::max(least, (off - tolerance) / places);
        most = std::min(most, (off + tolerance) / places);
    }
    points_.push_back(point(last));
}

void Pen::draw(const InkLine& line, double width) {
    points_.clear();
    points_.push_back({line.points.front().at, aimBeside(line.points.front()).depth, width});
    for (std::size_t k = 1; k < line.points.size(); ++k) {
        const LinePoint &from = line.points[k - 1], &to = line.points[k];
        const double parts = partsOf(from.at, to.at);
        aims_.clear();
        for (double part = 0.0; part <= parts; ++part) {
            const double share = part / parts;
            aims_.push_back(
                aimBeside({glm::mix(from.at, to.at, share), std::lerp(from.depth, to.depth, share), 0.0}));
        }
        lay(from.at, to.at, width);
    }
    put();
}

void Pen::draw(const HatchStroke& stroke, double width) {
    points_.clear();
    Aim last{HUGE_VAL, 0.0};
    for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
        const glm::dvec2 &from = stroke.points[i], &to = stroke.points[i + 1];
        const double parts = partsOf(from, to);
        aims_.clear();
        for (double part = 0.0; part <= parts; ++part)
            aims_.push_back(aimOn(glm::mix(from, to, part / parts)));
        if (i > 0 && std::isfinite(last.depth)) aims_.front() = last;
        // Some places may lie just beside what is seen.
        const auto isKnown = [](const Aim& aim) { return std::isfinite(aim.depth); };
        const auto first = std::find_if(aims_.begin(), aims_.end(), isKnown);
        if (first == aims_.end()) continue;
        std::fill(aims_.begin(), first, *first);
        for (std::size_t k = 1; k < aims_.size(); ++k) {
            if (!isKnown(aims_[k])) aims_[k] = aims_[k - 1];
        }
        last = aims_.back();
        if (points_.empty()) points_.push_back({from, aims_.front().depth, width});
        lay(from, to, width);
    }
    if (points_.size() > 1) put();
}

void Pen::fill(const std::vector<Outline>& outlines, const std::stop_token& stop) {
    if (outlines.empty()) return;
    auto depths = leastAlong(leastAlong(modalities_.depth));
    spread(depths, stop);
    const auto off = static_cast<float>(nearer * modalities_.extent);
    for (auto& depth : depths.values) depth -= off;
    strokes_.areaDepths = {depths.width, depths.height, std::move(depths.values)};
    for (std::size_t i = 0; i < outlines.size(); ++i) {
        const auto begin = static_cast<std::uint32_t>(strokes_.points.size());
        for (const auto& at : outlines[i].points)
            strokes_.points.push_back({static_cast<float>(at.x), static_cast<float>(at.y), 1.0F, 0.0});
        const auto number = static_cast<std::uint32_t>(strokes_.outlines.size());
        strokes_.outlines.push_back({begin, static_cast<std::uint32_t>(strokes_.points.size())});
        if (i == 0 || outlines[i].region != outlines[i - 1].region)
            strokes_.areas.push_back({number, number});
        strokes_.areas.back().end = number + 1;
    }
}

void Pen::put() {
    if (hand_.waver > 0.0 || hand_.taper) subdivide();
    if (hand_.waver > 0.0) waver();
    if (hand_.taper) taper();
    const auto begin = static_cast<std::uint32_t>(strokes_.points.size());
    for (const auto& point : points_) {
        strokes_.points.push_back({static_cast<float>(point.at.x), static_cast<float>(point.at.y),
                                   static_cast<float>(point.width),
                                   point.depth - nearer * modalities_.extent});
    }
    strokes_.lines.push_back({begin, static_cast<std::uint32_t>(strokes_.points.size())});
}

/// A hand needs places to change at.
void Pen::subdivide() {
    std::vector<Point> all{points_.front()};
    for (std::size_t i = 1; i < points_.size(); ++i) {
        const Point &from = points_[i - 1], &to = points_[i];
        const double parts = std::clamp(std::ceil(glm::distance(from.at, to.at) / handEvery), 1.0, 4096.0);
        for (double part = 1.0; part <= parts; ++part) {
            const double share = part / parts;
            all.push_back({glm::mix(from.at, to.at, share), std::lerp(from.depth, to.depth, share),
                           std::lerp(from.width, to.width, share)});
        }
    }
    points_ = std::move(all);
}

/// Off the way by noise that is even between places a wave apart.
void Pen::waver() {
    const std::uint64_t seed = seedOf(points_.front().at);
    double along = 0.0;
    std::vector<Point> moved;
    for (std::size_t i = 0; i < points_.size(); ++i) {
        const glm::dvec2 way =
            points_[std::min(i + 1, points_.size() - 1)].at - points_[i > 0 ? i - 1 : 0].at;
        const double length = glm::length(way);
        const auto place = static_cast<std::uint64_t>(along / wave);
        const double share = along / wave - static_cast<double>(place),
                     even = share * share * (3.0 - 2.0 * share);
        const double off = std::lerp(noise(seed, place), noise(seed, place + 1), even) - 0.5;
        Point point = points_[i];
        // Even noise on [-1/2, 1/2] has a standard deviation of 1 / sqrt(12).
        if (length > 0.0)
            point.at += std::sqrt(12.0) * hand_.waver * off / length * glm::dvec2(-way.y, way.x);
        moved.push_back(point);
        if (i + 1 < points_.size()) along += glm::distance(points_[i].at, points_[i + 1].at);
    }
    points_ = std::move(moved);
}

void Pen::taper() {
    double length = 0.0;
    for (std::size_t i = 0; i + 1 < points_.size(); ++i)
        length += glm::distance(points_[i].at, points_[i + 1].at);
    const double tapered = std::min(mostTapered, 0.5 * length);
    if (!(tapered > 0.0)) return;
    double along = 0.0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
        const double fromEnd = std::min(along, length - along);
        points_[i].width *= std::lerp(thinnest, 1.0, std::clamp(fromEnd / tapered, 0.0, 1.0));
        if (i + 1 < points_.size()) along += glm::distance(points_[i].at, points_[i + 1].at);
    }
}

}  // namespace mote::render
