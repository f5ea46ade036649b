// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/volume_lines.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "server/render/ink/ink_line.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr float steepest = 0.025F;  // a pixel, that an opacity falls by where matter thins out

struct Neighbour {
    int column, row;
    float distance;
};

/// One of the two passes of a distance transform, by the neighbours that come before a pixel (Borgefors 1986,
/// Distance transformations in digital images).
void spread(Raster<float>& distance, int direction) {
    constexpr float aslant = 1.41421356F;
    constexpr std::array<Neighbour, 4> before{
        {{-1, 0, 1.0F}, {-1, -1, aslant}, {0, -1, 1.0F}, {1, -1, aslant}}};
    const auto width = static_cast<int>(distance.width), height = static_cast<int>(distance.height);
    const auto at = [&](int column, int row) -> float& {
        return distance.at(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row));
    };
    for (int i = 0; i < height; ++i) {
        giveWay();
        for (int k = 0; k < width; ++k) {
            const int row = direction > 0 ? i : height - 1 - i, column = direction > 0 ? k : width - 1 - k;
            for (const auto& one : before) {
                const int x = column + direction * one.column, y = row + direction * one.row;
                if (x < 0 || y < 0 || x >= width || y >= height) continue;
                at(column, row) = std::min(at(column, row), at(x, y) + one.distance);
            }
        }
    }
}

constexpr float level = surfaceOpacity;
constexpr double sureStep = 0.012;  // of the extent, somewhere along a line
constexpr double shortest = 8.0;    // pixels of a line
constexpr double rounding = 1.0;    // standard deviation over which a line is made smooth, pixels

/// The border between two rays: between `ray` and the one below it, or to the right of it.
struct Crack {
    std::uint32_t x, y;
    bool below;
};

/// A corner of four rays.
struct Corner {
    std::uint32_t x, y;
    bool operator==(const Corner&) const = default;
};

/// Which borders of rays are lines, and which of them have been followed.
class Cracks {
  public:
    Cracks(const VolumeModalities& seen, const std::stop_token& stop)
        : seen_(seen), flags_(seen.opacity.width, seen.opacity.height) {
        forPixelsInTurns(flags_.width, flags_.height,
                         [&](std::uint32_t y, std::uint32_t from, std::uint32_t to) {
                             if (isStopped(stop)) return;
                             for (std::uint32_t x = from; x < to; ++x) {
                                 unsigned flags = 0;
                                 for (const bool below : {false, true}) {
                                     if (parts({x, y, below})) flags |= lineFlag(below);
                                 }
                                 flags_.at(x, y) = static_cast<std::uint8_t>(flags);
                             }
                         });
    }

    std::uint32_t columns() const { return flags_.width + 1; }  ///< of corners
    std::uint32_t rows() const { return flags_.height + 1; }

    /// The crack from a corner to the next one in a direction: right, down, left, up.
    bool line(const Corner& corner, unsigned direction) const { return has(corner, direction, lineFlag); }
    bool open(const Corner& corner, unsigned direction) const {
        return line(corner, direction) && !has(corner, direction, takenFlag);
    }
    unsigned degree(const Corner& corner) const {
        unsigned count = 0;
        for (unsigned direction = 0; direction < 4; ++direction) count += line(corner, direction) ? 1 : 0;
        return count;
    }
    void take(const Corner& corner, unsigned direction) {
        const Crack crack = crackOf(corner, direction);
        flags_.at(crack.x, crack.y) |= static_cast<std::uint8_t>(takenFlag(crack.below));
    }

    /// Where a line passes between the two rays; in rays.
    LinePoint point(const Corner& corner, unsigned direction) const {
        const Crack crack = crackOf(corner, direction);
        const std::size_t one = flags_.index(crack.x, crack.y),
                          other = crack.below ? one + flags_.width : one + 1;
        const float a = seen_.opacity.values[one], b = seen_.opacity.values[other];
        const bool outline = (a >= level) != (b >= level);
        const double share = outline ? static_cast<double>((level - a) / (b - a)) : 0.5;
        LinePoint point{.at = {crack.x + 0.5, crack.y + 0.5}};
        point.at[crack.below ? 1 : 0] += share;
        const double near = depth(one), far = depth(other);
        point.depth = std::min(near, far);
        point.step = outline ? 1.0 : std::min(std::abs(far - near) / seen_.modalities.extent, 1.0);
        return point;
    }

  private:
    static unsigned lineFlag(bool below) { return below ? 2U : 1U; }
    static unsigned takenFlag(bool below) { return below ? 8U : 4U; }

    template <class Flag>
    bool has(const Corner& corner, unsigned direction, const Flag& flag) const {
        const Crack crack = crackOf(corner, direction);
        // Before the first column and row numbers wrap around.
        if (crack.x >= flags_.width || crack.y >= flags_.height) return false;
        return (flags_.at(crack.x, crack.y) & flag(crack.below)) != 0;
    }
    static Crack crackOf(const Corner& corner, unsigned direction) {
        const auto [x, y] = corner;
        constexpr std::array below{true, false, true, false};
        return {direction == 0 ? x : x - 1, direction == 1 ? y : y - 1, below[direction]};
    }

    double depth(std::size_t ray) const {
        return seen_.opacity.values[ray] >= level ? static_cast<double>(seen_.depth.values[ray]) : HUGE_VAL;
    }
    /// Whether one of two rays sees a surface and the other none, or one much farther away.
    bool parts(const Crack& crack) const {
        const std::size_t width = flags_.width, ray = flags_.index(crack.x, crack.y);
        const std::size_t at = crack.below ? crack.y : crack.x, stride = crack.below ? width : 1;
        const std::size_t last = (crack.below ? flags_.height : width) - 1;
        if (at >= last) return false;
        const double from = depth(ray), to = depth(ray + stride);
        if (!std::isfinite(from) || !std::isfinite(to)) return std::isfinite(from) != std::isfinite(to);
        const double most = leastDepthStep * seen_.modalities.extent, step = to - from;
        const double before = at > 0 ? from - depth(ray - stride) : HUGE_VAL;
        const double behind = at + 1 < last ? depth(ray + 2 * stride) - to : HUGE_VAL;
        // A surface that turns away grows steeper from ray to ray, but not by as much again.
        const auto goesOn = [&](double slope) {
            return std::isfinite(slope) && std::abs(step - slope) <= most + std::abs(slope);
        };
        return std::abs(step) > most && !goesOn(before) && !goesOn(behind);
    }

    const VolumeModalities& seen_;
    Raster<std::uint8_t> flags_;
};

Corner after(const Corner& corner, unsigned direction) {
    constexpr std::array<std::uint32_t, 4> right{1, 0, UINT32_MAX, 0}, down{0, 1, 0, UINT32_MAX};
    return {corner.x + right[direction], corner.y + down[direction]};
}

/// Follows lines from corner to corner.
class Tracer {
  public:
    Tracer(const VolumeModalities& seen, const std::stop_token& stop) : seen_(seen), cracks_(seen, stop) {}

    std::vector<InkLine> trace(const std::stop_token& stop) {
        // Lines that begin and end somewhere, then closed ones.
        for (const bool closed : {false, true}) {
            for (std::uint32_t y = 0; y < cracks_.rows() && !isStopped(stop); ++y) {
                for (std::uint32_t x = 0; x < cracks_.columns(); ++x) begin({x, y}, closed);
            }
        }
        return std::move(lines_);
    }

  private:
    void begin(const Corner& corner, bool closed) {
        if (!closed && cracks_.degree(corner) == 2) return;
        for (unsigned direction = 0; direction < 4; ++direction) {
            if (cracks_.open(corner, direction)) follow(corner, direction);
        }
    }
    void follow(const Corner& start, unsigned direction) {
        points_.clear();
        addEnd(start);
        Corner corner = start;
        for (bool goesOn = true; goesOn;) {
            points_.push_back(cracks_.point(corner, direction));
            cracks_.take(corner, direction);
            corner = after(corner, direction);
            goesOn = cracks_.degree(corner) == 2 && turn(corner, direction);
        }
        const bool closed = corner == start && cracks_.degree(corner) == 2;
        if (!closed) addEnd(corner);
        put(closed);
    }
    /// The way on from a corner that a line comes to.
    bool turn(const Corner& corner, unsigned& direction) const {
        for (unsigned next = 0; next < 4; ++next) {
            if (!cracks_.open(corner, next)) continue;
            direction = next;
            return true;
        }
        return false;
    }
    /// Where lines meet, or one ends: the middle of all that are there.
    void addEnd(const Corner& corner) {
        if (cracks_.degree(corner) == 2) return;
        LinePoint mean;
        double count = 0.0;
        for (unsigned direction = 0; direction < 4; ++direction) {
            if (!cracks_.line(corner, direction)) continue;
            const auto point = cracks_.point(corner, direction);
            mean.at += point.at;
            mean.depth += point.depth;
            count += 1.0;
        }
        const bool alone = count == 1.0;
        mean.at = alone ? glm::dvec2(corner.x, corner.y) : mean.at / count;
        mean.depth /= count;
        points_.push_back(mean);
    }

    void put(bool closed) {
        if (points_.size() < 2) return;
        if (!closed) {
            points_.front().step = points_[1].step;
            points_.back().step = points_[points_.size() - 2].step;
        }
        if (!isLine()) return;
        smooth(closed);
        if (closed) points_.push_back(points_.front());
        for (auto& point : points_) point.at /= static_cast<double>(seen_.side);
        simplify(points_);
        lines_.push_back({LineKind::silhouette, points_});
    }
    bool isLine() const {
        double length = 0.0, most = 0.0;
        for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
            length += glm::distance(points_[i].at, points_[i + 1].at);
            most = std::max(most, points_[i].step);
        }
        return length >= shortest * seen_.side && most >= sureStep;
    }
    /// By weights of 1, 2 and 1, again and again: about a Gaussian. Ends stay.
    void smooth(bool closed) {
        const std::size_t count = points_.size(), first = closed ? 0 : 1, last = closed ? count : count - 1;
        const auto rounds = static_cast<int>(2.0 * rounding * rounding * seen_.side * seen_.side);
        for (int round = 0; round < rounds; ++round) {
            before_ = points_;
            for (std::size_t i = first; i < last; ++i) {
                const auto &a = before_[(i + count - 1) % count], &b = before_[(i + 1) % count];
                LinePoint& point = points_[i];
                point.at = 0.5 * point.at + 0.25 * (a.at + b.at);
                point.depth = 0.5 * point.depth + 0.25 * (a.depth + b.depth);
                point.step = 0.5 * point.step + 0.25 * (a.step + b.step);
            }
        }
    }

    const VolumeModalities& seen_;
    Cracks cracks_;
    std::vector<LinePoint> points_, before_;  // of the line that is followed, in rays
    std::vector<InkLine> lines_;
};

}  // namespace

Raster<std::uint8_t> rimsOf(const Raster<float>& opacity) {
    Raster<float> distance(opacity.width, opacity.height, HUGE_VALF);
    for (std::size_t i = 0; i < opacity.values.size(); ++i) {
        if (opacity.values[i] >= surfaceOpacity) distance.values[i] = 0.0F;
    }
    spread(distance, 1);
    spread(distance, -1);
    Raster<std::uint8_t> rims(opacity.width, opacity.height);
    for (std::size_t i = 0; i < rims.values.size(); ++i) {
        const float fallen = surfaceOpacity - opacity.values[i];
        rims.values[i] = fallen > 0.0F && fallen > steepest * distance.values[i] ? 1 : 0;
    }
    return rims;
}

std::vector<InkLine> linesOf(const VolumeModalities& seen, const std::stop_token& stop) {
    return Tracer(seen, stop).trace(stop);
}

}  // namespace mote::render
