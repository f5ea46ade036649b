// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/page_ink.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>

#include "server/encode/vector/ink_outline.h"
#include "server/encode/vector/tour.h"

namespace mote::server {
namespace {

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
