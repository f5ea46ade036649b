// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/page_ink.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "server/encode/vector/tour.h"

namespace mote::server {
namespace {

using render::Stroke;
using render::StrokePoint;
using render::Strokes;

constexpr int widthsPerOctave = 16;
constexpr double leastWidth = 1.0 / 64, mostWidth = 1 << 14;  ///< pixels
constexpr double leastLength = 0.04;                          ///< pixels: a pen must be moved to leave a mark

/// Which power of 2^(1/16) a width is.
int levelOf(double width) {
    return static_cast<int>(
        std::lround(widthsPerOctave * std::log2(std::clamp(width, leastWidth, mostWidth))));
}

glm::dvec2 placeOf(const StrokePoint& point) {
    return {point.x, point.y};
}

/// Makes lines of one width each from lines of changing width.
class InkLines {
  public:
    InkLines(std::uint32_t width, std::uint32_t height, std::map<double, PagePaths>& lines)
        : size_(width, height), lines_(lines) {}

    void add(std::span<const StrokePoint> points) {
        if (points.size() == 1) addPart(placeOf(points[0]), placeOf(points[0]), levelOf(points[0].width));
        for (std::size_t i = 1; i < points.size(); ++i) addSegment(points[i - 1], points[i]);
        finish();
    }

  private:
    /// In as many parts of equal length as its width goes through levels.
    void addSegment(const StrokePoint& from, const StrokePoint& to) {
        if (!(std::max(from.width, to.width) > 0.0F)) return finish();
        const int parts = std::max(1, std::abs(levelOf(to.width) - levelOf(from.width)));
        for (int i = 0; i < parts; ++i) {
            const double begin = static_cast<double>(i) / parts, end = (i + 1.0) / parts;
            const double width = from.width + 0.5 * (begin + end) * (double{to.width} - from.width);
            addPart(glm::mix(placeOf(from), placeOf(to), begin), glm::mix(placeOf(from), placeOf(to), end),
                    levelOf(width));
        }
    }
    void addPart(const glm::dvec2& from, const glm::dvec2& to, int level) {
        const double reach = std::exp2(static_cast<double>(level) / widthsPerOctave);
        const glm::dvec2 low = glm::min(from, to) - reach, high = glm::max(from, to) + reach;
        if (high.x < 0.0 || high.y < 0.0 || low.x > size_.x || low.y > size_.y) return finish();
        if (!path_.empty() && level != level_) finish();
        if (path_.empty()) path_.push_back(from);
        path_.push_back(to);
        level_ = level;
    }
    void finish() {
        if (path_.empty()) return;
        lines_[std::exp2(static_cast<double>(level_) / widthsPerOctave)].add(path_);
        path_.clear();
    }

    const glm::dvec2 size_;
    std::map<double, PagePaths>& lines_;
    std::vector<glm::dvec2> path_;
    int level_ = 0;
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
    InkLines lines(width, height, ink.lines);
    const auto pointsOf = [&](const Stroke& stroke) {
        return std::span(strokes.points).subspan(stroke.begin, stroke.end - stroke.begin);
    };
    for (const auto& line : strokes.lines) lines.add(pointsOf(line));
    for (const auto& area : strokes.areas) {
        PagePaths outlines;
        for (auto i = area.begin; i < area.end; ++i) {
            std::vector<glm::dvec2> outline;
            for (const auto& point : pointsOf(strokes.outlines[i])) outline.push_back(placeOf(point));
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
