// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/cut_strokes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <map>
#include <numbers>
#include <optional>

#include "protocol/scene/srgb.h"
#include "server/encode/vector/clip_path.h"
#include "server/encode/vector/paint.h"

namespace mote::server {
namespace {

using render::Strokes, render::StrokePoint;

constexpr int colorSteps = 63;                        // of an encoded channel
constexpr int alikeSteps = 2;                         // colours of one piece differ by no more
constexpr int largeStep = 6;                          // at which a line ends as at something that hides it
constexpr double endShare = 0.25 * std::numbers::pi;  // of half a width: a round end that covers as much

/// Encoded, in steps; none where nothing is seen.
using ColorKey = std::optional<std::array<int, 3>>;

bool within(const ColorKey& a, const ColorKey& b, int steps) {
    if (!a || !b) return !a && !b;
    for (std::size_t i = 0; i < 3; ++i) {
        if (std::abs((*a)[i] - (*b)[i]) > steps) return false;
    }
    return true;
}

/// Of one colour.
struct Piece {
    ColorKey key;
    std::vector<StrokePoint> points;
};

double lengthOf(const std::vector<StrokePoint>& points) {
    double length = 0.0;
    for (std::size_t i = 1; i < points.size(); ++i)
        length += std::hypot(points[i].x - points[i - 1].x, points[i].y - points[i - 1].y);
    return length;
}

/// Leaves out so much of a line's end.
void shortenEnd(std::vector<StrokePoint>& points, double amount) {
    while (points.size() > 1) {
        const auto &from = points[points.size() - 2], &to = points.back();
        const double length = std::hypot(to.x - from.x, to.y - from.y);
        if (length > amount) {
            points.back() = pointBetween(from, to, 1.0 - amount / length);
            return;
        }
        amount -= length;
        points.pop_back();
    }
}

/// Round ends go beyond the points that they end at: where something hides the line from there on, it ends
/// earlier by as much as makes the end cover what a straight one would.
void shorten(std::vector<StrokePoint>& points, bool front, bool back) {
    const double most = 0.45 * lengthOf(points);
    if (back) shortenEnd(points, std::min(most, endShare * 0.5 * points.back().width));
    if (!front) return;
    std::reverse(points.begin(), points.end());
    shortenEnd(points, std::min(most, endShare * 0.5 * points.back().width));
    std::reverse(points.begin(), points.end());
}

class StrokeCutter {
  public:
    StrokeCutter(const Strokes& strokes, const Sight& sight, const PictureSize& size, bool plotter)
        : strokes_(strokes), sight_(sight), size_(size), plotter_(plotter), own_(keyOf(strokes.color)) {}

    std::vector<Strokes> cut() {
        for (const auto& line : strokes_.lines) cutLine(line);
        for (const auto& area : strokes_.areas) cutArea(area);
        std::vector<Strokes> seen{std::move(clear_)};
        seen.front().color = strokes_.color;
        for (auto& [key, part] : parts_) seen.push_back(std::move(part));
        for (auto& part : seen) part.opacity = strokes_.opacity;
        return seen;
    }

  private:
    static std::array<int, 3> keyOf(const glm::vec3& linear) {
        const auto color = encoded(linear);
        const auto step = [](float value) { return static_cast<int>(std::lround(colorSteps * value)); };
        return {step(color.x), step(color.y), step(color.z)};
    }
    static glm::vec3 colorOf(const std::array<int, 3>& key) {
        const glm::dvec3 color(key[0], key[1], key[2]);
        return glm::vec3(srgbToLinear(color / static_cast<double>(colorSteps)));
    }
    ColorKey seenAt(const glm::uvec2& pixel, double depth) const {
        const auto inFront = sight_.at(pixel.x, pixel.y, depth);
        if (plotter_) return inFront.through < 0.5F ? ColorKey() : own_;
        if (inFront.hidden()) return std::nullopt;
        return inFront.clear() ? own_ : keyOf(inFront.seen(strokes_.color));
    }
    ColorKey seenAt(const StrokePoint& point) const {
        return seenAt(pixelOf({point.x, point.y}, size_), point.depth);
    }
    Strokes& partOf(const std::array<int, 3>& key) {
        if (key == *own_) return clear_;
        auto& part = parts_[key];
        part.color = colorOf(key);
        return part;
    }

    void cutLine(const render::Stroke& line) {
        auto pieces = piecesOf(line);
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            auto& [key, points] = pieces[i];
            if (!key) continue;
            const auto ends = [&](std::size_t other) { return !within(pieces[other].key, key, largeStep); };
            shorten(points, i > 0 && ends(i - 1), i + 1 < pieces.size() && ends(i + 1));
            addPath(points, partOf(*key), &Strokes::lines);
        }
    }
    std::vector<Piece> piecesOf(const render::Stroke& line) const {
        const auto* const points = strokes_.points.data();
        std::vector<Piece> pieces;
        if (line.end == line.begin + 1) pieces.push_back({seenAt(points[line.begin]), {points[line.begin]}});
        for (auto i = line.begin + 1; i < line.end; ++i) {
            const auto &from = points[i - 1], &to = points[i];
            const auto parts = piecesBetween(from, to);
            for (std::uint32_t k = 0; k < parts; ++k) {
                const auto key = seenAt(pointBetween(from, to, (k + 0.5) / parts));
                if (!pieces.empty() && within(key, pieces.back().key, alikeSteps)) continue;
                const auto cut = pointBetween(from, to, static_cast<double>(k) / parts);
                if (!pieces.empty() && k > 0) pieces.back().points.push_back(cut);
                pieces.push_back({key, {cut}});
            }
            pieces.back().points.push_back(to);
        }
        return pieces;
    }
    static void addPath(const std::vector<StrokePoint>& points, Strokes& to,
                        std::vector<render::Stroke> Strokes::*list) {
        const auto begin = static_cast<std::uint32_t>(to.points.size());
        to.points.insert(to.points.end(), points.begin(), points.end());
        (to.*list).push_back({begin, static_cast<std::uint32_t>(to.points.size())});
    }

    /// Whole where all of it is seen alike, else row by row in runs of pixels that are.
    void cutArea(const render::InkArea& area) {
        const auto box = boxOf(strokes_, area, size_);
        bool anySeen = false, allOwn = true;
        double through = 0.0, pixels = 0.0;
        for (auto row = box.top; row < box.bottom; ++row) {
            for (auto column = box.left; column < box.right; ++column) {
                const auto depth = strokes_.areaDepths.at(column, row);
                if (depth == render::AreaDepths::none) continue;
                const auto key = seenAt({column, row}, depth);
                anySeen = anySeen || key;
                allOwn = allOwn && key == own_;
                through += key ? 1.0 : 0.0;
                pixels += 1.0;
            }
        }
        if (allOwn || (plotter_ && 2.0 * through >= pixels)) return addArea(area, std::nullopt, clear_);
        if (!anySeen || plotter_) return;
        for (auto row = box.top; row < box.bottom; ++row) cutRow(area, box, row);
    }
    void cutRow(const render::InkArea& area, const PixelBox& box, std::uint32_t row) {
        for (auto column = box.left; column < box.right;) {
            const auto key = seenInArea(column, row);
            auto end = column + 1;
            while (end < box.right && within(seenInArea(end, row), key, alikeSteps)) ++end;
            if (key) addArea(area, ClipBox{{column, row}, {end, row + 1}}, partOf(*key));
            column = end;
        }
    }
    ColorKey seenInArea(std::uint32_t column, std::uint32_t row) const {
        const auto depth = strokes_.areaDepths.at(column, row);
        return depth == render::AreaDepths::none ? ColorKey() : seenAt({column, row}, depth);
    }
    void addArea(const render::InkArea& area, const std::optional<ClipBox>& box, Strokes& to) const {
        const auto begin = static_cast<std::uint32_t>(to.outlines.size());
        for (auto i = area.begin; i < area.end; ++i) {
            const auto& outline = strokes_.outlines[i];
            std::vector<glm::dvec2> path;
            for (auto k = outline.begin; k < outline.end; ++k)
                path.emplace_back(strokes_.points[k].x, strokes_.points[k].y);
            if (box) path = clipped(path, *box);
            if (path.empty()) continue;
            std::vector<StrokePoint> points;
            for (const auto& at : path)
                points.push_back({static_cast<float>(at.x), static_cast<float>(at.y), 1.0F, 0.0});
            addPath(points, to, &Strokes::outlines);
        }
        if (to.outlines.size() > begin)
            to.areas.push_back({begin, static_cast<std::uint32_t>(to.outlines.size())});
    }

    const Strokes& strokes_;
    const Sight& sight_;
    const PictureSize size_;
    const bool plotter_;
    const ColorKey own_;
    Strokes clear_;
    std::map<std::array<int, 3>, Strokes> parts_;
};

}  // namespace

std::vector<Strokes> seenOf(const Strokes& strokes, const Sight& sight, const PictureSize& size,
                            bool plotter) {
    return StrokeCutter(strokes, sight, size, plotter).cut();
}

}  // namespace mote::server
