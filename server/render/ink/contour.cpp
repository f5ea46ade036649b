// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/contour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

#include "server/render/ink/merges.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr double outlineTolerance = 1.0 / 32;  // pixels that an outline may be off its points
constexpr double leastShare = 1.0 / 256;  // of the way between two pixels: outlines meet in no pixel's middle
constexpr std::size_t pointsPerStop = 65536;  // points
constexpr std::uint32_t notTraced = std::numeric_limits<std::uint32_t>::max();

/// A pixel, or what lies beside the picture.
struct Cell {
    std::int64_t x, y;
};

// Right, down, left, up: clockwise on the screen.
constexpr std::array<Cell, 4> ways{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
constexpr std::size_t left = 2;

constexpr Cell operator+(const Cell& a, const Cell& b) {
    return {a.x + b.x, a.y + b.y};
}
constexpr Cell operator-(const Cell& a, const Cell& b) {
    return {a.x - b.x, a.y - b.y};
}

/// From a pixel inside to its neighbour on a way, which is outside: an outline passes between them.
struct Link {
    Cell inside;
    std::size_t way;
};

double cross(const glm::dvec2& a, const glm::dvec2& b) {
    return a.x * b.y - a.y * b.x;
}

/// The directions from a place to all that lies near some points (Sklansky and Gonzalez 1980, Fast polygonal
/// approximation of digitized curves).
class Cone {
  public:
    explicit Cone(const glm::dvec2& tip) : tip_(tip) {}

    /// Whether the straight way to a point passes all those before, on the way there.
    bool reaches(const glm::dvec2& point) const {
        const glm::dvec2 off = point - tip_;
        if (glm::length(off) < farthest_) return false;
        return !narrowed_ || (cross(first_, off) >= 0.0 && cross(off, last_) >= 0.0);
    }
    void narrow(const glm::dvec2& point) {
        const glm::dvec2 off = point - tip_;
        const double distance = glm::length(off);
        farthest_ = distance;
        if (distance <= outlineTolerance) return;
        const double sine = outlineTolerance / distance, cosine = std::sqrt(1.0 - sine * sine);
        const glm::dvec2 side(-sine * off.y, sine * off.x);
        const glm::dvec2 first = cosine * off - side, last = cosine * off + side;
        if (!narrowed_ || cross(first_, first) > 0.0) first_ = first;
        if (!narrowed_ || cross(last, last_) > 0.0) last_ = last;
        narrowed_ = true;
    }

  private:
    glm::dvec2 tip_;
    glm::dvec2 first_{0.0}, last_{0.0};
    double farthest_ = 0.0;
    bool narrowed_ = false;
};

std::vector<glm::dvec2> simplified(const std::vector<glm::dvec2>& points) {
    std::vector<glm::dvec2> kept{points.front()};
    Cone cone(points.front());
    for (std::size_t i = 1; i <= points.size(); ++i) {
        const glm::dvec2& point = points[i % points.size()];
        if (!cone.reaches(point)) {
            kept.push_back(points[i - 1]);
            cone = Cone(points[i - 1]);
        }
        cone.narrow(point);
    }
    return kept;
}

/// Traces one picture's outlines.
class Tracer {
  public:
    Tracer(const Raster<float>& values, float level, const std::stop_token& stop)
        : values_(values), level_(level), stop_(stop), traced_(values.width + 1, values.height, notTraced) {}

    std::vector<Outline> trace() {
        for (std::uint32_t row = 0; row < values_.height && !isStopped(stop_); ++row) {
            for (std::uint32_t column = 0; column < values_.width; ++column) {
                const Cell at{column, row};
                if (inside(at) && !inside(at + ways[left]) && traced_.at(column, row) == notTraced)
                    follow({at, left});
            }
        }
        if (isStopped(stop_)) return {};
        return byRegions();
    }

  private:
    bool inPicture(const Cell& at) const {
        return at.x >= 0 && at.y >= 0 && at.x < values_.width && at.y < values_.height;
    }
    float valueOf(const Cell& at) const {
        return values_.at(static_cast<std::uint32_t>(at.x), static_cast<std::uint32_t>(at.y));
    }
    bool inside(const Cell& at) const { return inPicture(at) && valueOf(at) >= level_; }

    /// Whether the mean around a corner of four pixels is inside, of which `a` and `b` are opposite ones.
    /// Summed in one order, so that both outlines there are told the same.
    bool joined(const Cell& a, const Cell& b) const {
        const Cell low{std::min(a.x, b.x), std::min(a.y, b.y)};
        double sum = 0.0;
        for (const Cell& off : {Cell{0, 0}, Cell{1, 0}, Cell{0, 1}, Cell{1, 1}}) {
            if (!inPicture(low + off)) return false;
            sum += static_cast<double>(valueOf(low + off));
        }
        return sum >= 4.0 * static_cast<double>(level_);
    }
    /// Around the corner that lies clockwise of a link as it is seen from its pixel.
    Link next(const Link& link) const {
        const std::size_t aside = (link.way + 1) % ways.size(), back = (link.way + 3) % ways.size();
        const Cell beside = link.inside + ways[aside], opposite = beside + ways[link.way];
        const bool goesOn = inside(beside);
        if (inside(opposite)) {
            if (goesOn || joined(link.inside, opposite)) return {opposite, back};
            return {link.inside, aside};
        }
        return goesOn ? Link{beside, link.way} : Link{link.inside, aside};
    }
    glm::dvec2 placeOn(const Link& link) const {
        const Cell outside = link.inside + ways[link.way];
        double share = 0.5;
        if (inPicture(outside)) {
            const auto high = static_cast<double>(valueOf(link.inside)),
                       low = static_cast<double>(valueOf(outside));
            const double linear = (high - static_cast<double>(level_)) / (high - low);
            if (std::isfinite(linear)) share = std::clamp(linear, leastShare, 1.0 - leastShare);
        }
        const Cell way = ways[link.way];
        return {static_cast<double>(link.inside.x) + 0.5 + share * static_cast<double>(way.x),
                static_cast<double>(link.inside.y) + 0.5 + share * static_cast<double>(way.y)};
    }
    /// The number of the outline that passes between a pixel and its left or right neighbour.
    std::uint32_t& numberOn(const Link& link) {
        const auto column = link.inside.x + (link.way == left ? 0 : 1);
        return traced_.at(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(link.inside.y));
    }

    /// Comes back to where it began, as each link follows but one other.
    void follow(const Link& first) {
        const auto number = static_cast<std::uint32_t>(outlines_.size());
        points_.clear();
        Link link = first;
        do {
            points_.push_back(placeOn(link));
            if (link.way % 2 == 0) numberOn(link) = number;
            if (points_.size() % pointsPerStop == 0 && isStopped(stop_)) return;
            link = next(link);
        } while (link.way != first.way || link.inside.x != first.inside.x || link.inside.y != first.inside.y);
        outlines_.push_back({simplified(points_), number});
    }

    /// Outlines at both ends of a row's run of pixels inside bound one region: so each hole is told that of
    /// what lies left of it.
    void joinRegions(Merges& merges) const {
        for (std::uint32_t row = 0; row < values_.height; ++row) {
            std::uint32_t begin = notTraced;
            for (std::uint32_t link = 0; link <= values_.width; ++link) {
                const std::uint32_t number = traced_.at(link, row);
                if (number == notTraced) continue;
                if (begin == notTraced) {
                    begin = number;
                    continue;
                }
                merges.merge(begin, number);
                begin = notTraced;
            }
        }
    }
    std::vector<Outline> byRegions() {
        Merges merges(static_cast<std::uint32_t>(outlines_.size()));
        joinRegions(merges);
        for (auto& outline : outlines_) outline.region = merges.root(outline.region);
        std::erase_if(outlines_, [](const Outline& outline) { return outline.points.size() < 3; });
        std::stable_sort(outlines_.begin(), outlines_.end(),
                         [](const Outline& a, const Outline& b) { return a.region < b.region; });
        return std::move(outlines_);
    }

    const Raster<float>& values_;
    const float level_;
    const std::stop_token& stop_;
    Raster<std::uint32_t> traced_;  // numbers of outlines left of each pixel, and right of the last
    std::vector<Outline> outlines_;
    std::vector<glm::dvec2> points_;
};

}  // namespace

std::vector<Outline> contoursOf(const Raster<float>& values, float level, const std::stop_token& stop) {
    return Tracer(values, level, stop).trace();
}

double signedArea(const Outline& outline) {
    double twice = 0.0;
    const auto& points = outline.points;
    for (std::size_t i = 0; i < points.size(); ++i)
        twice += cross(points[i], points[i + 1 < points.size() ? i + 1 : 0]);
    return 0.5 * twice;
}

}  // namespace mote::render
