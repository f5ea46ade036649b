// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/page_ink.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "server/encode/vector/tour.h"
#include "server/render/plan/stroke.h"

namespace mote::server {
namespace {

/// The outline of a line whose width changes, for sheets, which know lines of one width only.
class InkOutline {
  public:
    /// Whether the way to a point bends so sharply at the last one that its outline would not follow.
    bool bendsTo(const render::StrokePoint& point) const;
    /// A point at the place of the last one is left out.
    void add(const render::StrokePoint& point);
    const render::StrokePoint& last() const { return points_.back(); }
    /// Appends the outline, which goes round in the same direction for all lines, and forgets the line.
    void finish(PagePaths& outlines);

  private:
    glm::dvec2 wayTo(std::size_t index) const;

    std::vector<render::StrokePoint> points_;
};

using render::StrokePoint;

constexpr double sharp = 0.5;       ///< cosine of a bend
constexpr double roundFrom = 0.75;  ///< half widths of ends that are more than a point; pixels

glm::dvec2 placeOf(const StrokePoint& point) {
    return {point.x, point.y};
}

glm::dvec2 leftOf(const glm::dvec2& way) {
    return {way.y, -way.x};
}

/// Half a circle around an end, from one side of the line to the other, its ends left out.
void addEnd(const StrokePoint& end, const glm::dvec2& outwards, std::vector<glm::dvec2>& path) {
    const double half = 0.5 * end.width;
    const int parts = half < roundFrom ? 2 : 4 + static_cast<int>(std::min(half, 32.0));
    for (int i = 1; i < parts; ++i) {
        const double angle = i * std::numbers::pi / parts;
        path.push_back(placeOf(end) +
                       half * (std::cos(angle) * leftOf(outwards) + std::sin(angle) * outwards));
    }
}

/// From the point before, of length 1.
glm::dvec2 InkOutline::wayTo(std::size_t index) const {
    return glm::normalize(placeOf(points_[index]) - placeOf(points_[index - 1]));
}

bool InkOutline::bendsTo(const StrokePoint& point) const {
    if (points_.size() < 2 || placeOf(point) == placeOf(last())) return false;
    const glm::dvec2 way = glm::normalize(placeOf(point) - placeOf(last()));
    return glm::dot(way, wayTo(points_.size() - 1)) < sharp;
}

void InkOutline::add(const StrokePoint& point) {
    if (points_.empty() || placeOf(point) != placeOf(last())) points_.push_back(point);
}

void InkOutline::finish(PagePaths& outlines) {
    std::vector<glm::dvec2> path, back;
    const std::size_t count = points_.size();
    for (std::size_t i = 0; i < count && count > 1; ++i) {
        const glm::dvec2 way =
            glm::normalize(wayTo(std::max<std::size_t>(i, 1)) + wayTo(std::min(i + 1, count - 1)));
        const glm::dvec2 side = 0.5 * points_[i].width * leftOf(way);
        path.push_back(placeOf(points_[i]) + side);
        back.push_back(placeOf(points_[i]) - side);
    }
    if (count > 1) {
        addEnd(points_.back(), wayTo(count - 1), path);
        path.insert(path.end(), back.rbegin(), back.rend());
        addEnd(points_.front(), -wayTo(1), path);
        outlines.add(path);
    }
    points_.clear();
}

using render::Stroke;
using render::StrokePoint;
using render::Strokes;

constexpr int widthsPerOctave = 16;
constexpr double leastWidth = 1.0 / 64, mostWidth = 1 << 14;  ///< pixels
constexpr double leastLength = 0.04;                          ///< pixels: a pen must be moved to leave a mark

/// The nearest power of 2^(1/16).
double penOf(double width) {
    const double level = std::round(widthsPerOctave * std::log2(std::clamp(width, leastWidth, mostWidth)));
    return std::exp2(level / widthsPerOctave);
}

glm::dvec2 pointOf(const StrokePoint& point) {
    return {point.x, point.y};
}

/// Makes paths and outlines of lines, without what lies outside the picture or has no width.
class InkLines {
  public:
    InkLines(std::uint32_t width, std::uint32_t height, bool plotter, PageInk& ink)
        : size_(width, height), plotter_(plotter), ink_(ink) {}

    void add(std::span<const StrokePoint> points) {
        if (points.size() == 1 && seen(points[0], points[0])) addWay(std::array{points[0], points[0]});
        for (std::size_t i = 1; i < points.size(); ++i) {
            if (!seen(points[i - 1], points[i])) {
                finish();
                continue;
            }
            if (part_.empty()) part_.push_back(points[i - 1]);
            part_.push_back(points[i]);
        }
        finish();
    }

  private:
    bool seen(const StrokePoint& from, const StrokePoint& to) const {
        const double reach = std::max(from.width, to.width);
        const glm::dvec2 low = glm::min(pointOf(from), pointOf(to)) - reach;
        const glm::dvec2 high = glm::max(pointOf(from), pointOf(to)) + reach;
        return reach > 0.0 && high.x > 0.0 && high.y > 0.0 && low.x < size_.x && low.y < size_.y;
    }
    void finish() {
        if (part_.empty()) return;
        const auto [least, most] = std::minmax_element(
            part_.begin(), part_.end(), [](const auto& a, const auto& b) { return a.width < b.width; });
        if (plotter_ || most->width <= 1.1F * least->width)
            addWay(part_);
        else
            addOutlines();
        part_.clear();
    }
    void addWay(std::span<const StrokePoint> points) {
        std::vector<glm::dvec2> way;
        double sum = 0.0;
        for (const auto& point : points) {
            way.push_back(pointOf(point));
            sum += point.width;
        }
        ink_.lines[penOf(sum / static_cast<double>(points.size()))].add(way);
    }
    /// One more from each sharp bend on: both have a round end there.
    void addOutlines() {
        InkOutline outline;
        for (const auto& point : part_) {
            if (outline.bendsTo(point)) {
                const StrokePoint corner = outline.last();
                outline.finish(ink_.outlines);
                outline.add(corner);
            }
            outline.add(point);
        }
        outline.finish(ink_.outlines);
    }

    const glm::dvec2 size_;
    const bool plotter_;
    PageInk& ink_;
    std::vector<StrokePoint> part_;
};

/// In the order of a short tour through their beginnings, each with a length.
PagePaths forPen(const PagePaths& paths) {
    std::vector<glm::dvec2> begins;
    for (std::size_t i = 0; i < paths.size(); ++i) begins.push_back(paths.of(i)[0]);
    PagePaths ordered;
    for (const auto i : shortTour(begins)) {
        std::vector<glm::dvec2> path(paths.of(i).begin(), paths.of(i).end());
        if (path.size() == 2 && path[0] == path[1]) path[1].x += leastLength;
        ordered.add(path);
    }
    return ordered;
}

}  // namespace

PageInk inkOnPage(const Strokes& strokes, std::uint32_t width, std::uint32_t height, bool plotter) {
    PageInk ink;
    InkLines lines(width, height, plotter, ink);
    const auto pointsOf = [&](const Stroke& stroke) {
        return std::span(strokes.points).subspan(stroke.begin, stroke.end - stroke.begin);
    };
    for (const auto& line : strokes.lines) lines.add(pointsOf(line));
    for (const auto& area : strokes.areas) {
        PagePaths outlines;
        for (auto i = area.begin; i < area.end; ++i) {
            std::vector<glm::dvec2> outline;
            for (const auto& point : pointsOf(strokes.outlines[i])) outline.push_back(pointOf(point));
            if (outline.empty()) continue;
            if (plotter) outline.push_back(outline.front());
            outlines.add(outline);
        }
        if (plotter) {
            for (std::size_t i = 0; i < outlines.size(); ++i) ink.lines[1.0].add(outlines.of(i));
        } else if (outlines.size() > 0) {
            ink.areas.push_back(std::move(outlines));
        }
    }
    for (auto& [pen, paths] : ink.lines) {
        if (plotter) paths = forPen(paths);
    }
    return ink;
}

}  // namespace mote::server
