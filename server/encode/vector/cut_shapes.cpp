// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/cut_shapes.h"

#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "protocol/scene/srgb.h"

namespace mote::server {
namespace {

constexpr float alikeWithin = 0.06F;  // of encoded colours: 15 of 255
constexpr float littleInk = 0.05F;    // of a pixel: its colour is not looked at
constexpr float halfThrough = 0.5F;

struct CoveredPixel {
    std::uint32_t column, row;
    float covers;
    InFront inFront;
    glm::vec3 seen;  // linear RGB
};

float difference(const glm::vec3& a, const glm::vec3& b) {
    const auto apart = glm::abs(encoded(a) - encoded(b));
    return std::max({apart.x, apart.y, apart.z});
}

/// What is seen of it, all in all.
struct Mean {
    InFront inFront{glm::vec3(0.0F), 0.0F};
    glm::vec3 seen{0.0F};
};

Mean meanOf(const std::vector<CoveredPixel>& pixels) {
    Mean mean;
    float sum = 0.0F;
    for (const auto& pixel : pixels) {
        mean.inFront.light += pixel.covers * pixel.inFront.light;
        mean.inFront.through += pixel.covers * pixel.inFront.through;
        mean.seen += pixel.covers * pixel.seen;
        sum += pixel.covers;
    }
    mean.inFront.light /= sum;
    mean.inFront.through /= sum;
    mean.seen /= sum;
    return mean;
}

/// Runs of pixels of a row that are alike, but for those in which it is hidden.
std::vector<SeenDot> piecesOf(const render::Dot& dot, const std::vector<CoveredPixel>& pixels) {
    std::vector<SeenDot> pieces;
    const auto disc = discPath(dot.radius);
    const glm::dvec2 centre(dot.x, dot.y);
    for (std::size_t begin = 0; begin < pixels.size();) {
        const auto& first = pixels[begin];
        std::size_t end = begin + 1;
        const auto goesOn = [&](const CoveredPixel& next) {
            return next.row == first.row && next.column == first.column + (end - begin) &&
                   next.inFront.hidden() == first.inFront.hidden() &&
                   difference(next.seen, first.seen) <= alikeWithin;
        };
        while (end < pixels.size() && goesOn(pixels[end])) ++end;
        const glm::dvec2 low(first.column, first.row);
        const ClipBox box{low - centre, low + glm::dvec2(end - begin, 1.0) - centre};
        if (!first.inFront.hidden()) {
            const auto mean = meanOf({pixels.begin() + static_cast<std::ptrdiff_t>(begin),
                                      pixels.begin() + static_cast<std::ptrdiff_t>(end)});
            if (auto outline = clipped(disc, box); !outline.empty())
                pieces.push_back({mean.seen, std::move(outline)});
        }
        begin = end;
    }
    return pieces;
}

constexpr int discCorners = 32;

/// What lies where sign * (place[axis] - at) >= 0.
std::vector<glm::dvec2> cutAt(std::span<const glm::dvec2> path, int axis, double at, double sign) {
    std::vector<glm::dvec2> kept;
    for (std::size_t i = 0; i < path.size(); ++i) {
        const auto &from = path[i == 0 ? path.size() - 1 : i - 1], &to = path[i];
        const double before = sign * (from[axis] - at), here = sign * (to[axis] - at);
        if ((before >= 0.0) != (here >= 0.0)) {
            glm::dvec2 crossing = from + before / (before - here) * (to - from);
            crossing[axis] = at;
            kept.push_back(crossing);
        }
        if (here >= 0.0) kept.push_back(to);
    }
    return kept;
}

using render::Strokes, render::StrokePoint;

constexpr int colorSteps = 63;                        // of an encoded channel
constexpr int alikeSteps = 2;                         // colours of one piece differ by no more
constexpr int largeStep = 6;                          // at which a line ends as at something that hides it
constexpr double endShare = 0.25 * std::numbers::pi;  // of half a width: a round end that covers as much

/// Encoded, in steps; none if nothing is seen.
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

/// Round ends go beyond the points that they end at: if something hides the line from there on, it ends
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

    /// Whole if all of it is seen alike, else row by row in runs of pixels that are.
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

std::vector<SeenDot> seenOf(const render::Dot& dot, const Sight& sight, const PictureSize& size,
                            bool plotter) {
    std::vector<CoveredPixel> pixels;
    bool allClear = true, allHidden = true;
    forCovered(dot, size, [&](std::uint32_t column, std::uint32_t row, float covers) {
        const auto inFront = sight.at(column, row, dot.depth);
        allClear = allClear && inFront.clear();
        allHidden = allHidden && inFront.hidden();
        pixels.push_back({column, row, covers, inFront, inFront.seen(dot.color)});
    });
    if (allClear) return {{dot.color, {}}};  // also out of the picture
    if (allHidden) return {};
    const Mean mean = meanOf(pixels);
    if (plotter) {
        if (mean.inFront.through < halfThrough) return {};
        return {{dot.color, {}}};
    }
    const bool even = std::all_of(pixels.begin(), pixels.end(), [&](const CoveredPixel& pixel) {
        return pixel.covers < littleInk || difference(pixel.seen, mean.seen) <= alikeWithin;
    });
    if (even) return {{mean.seen, {}}};
    return piecesOf(dot, pixels);
}

std::vector<glm::dvec2> clipped(std::span<const glm::dvec2> path, const ClipBox& box) {
    std::vector<glm::dvec2> kept(path.begin(), path.end());
    for (int axis = 0; axis < 2; ++axis) {
        kept = cutAt(kept, axis, box.low[axis], 1.0);
        kept = cutAt(kept, axis, box.high[axis], -1.0);
    }
    if (kept.size() < 3) kept.clear();
    return kept;
}

std::vector<glm::dvec2> discPath(double radius) {
    constexpr double turn = 2.0 * std::numbers::pi / discCorners;
    const double corner = radius * std::sqrt(turn / std::sin(turn));
    std::vector<glm::dvec2> path;
    for (int i = 0; i < discCorners; ++i)
        path.emplace_back(corner * std::cos(i * turn), corner * std::sin(i * turn));
    return path;
}

glm::vec3 encoded(const glm::vec3& linear) {
    return glm::vec3(linearToSrgb(glm::clamp(glm::dvec3(linear), 0.0, 1.0)));
}

Paint paintOver(const glm::vec3& color, double opacity, const glm::vec3& beneath, double least) {
    if (opacity >= 1.0 || !(opacity > 0.0)) return {encoded(color), std::clamp(opacity, 0.0, 1.0)};
    const auto share = static_cast<float>(opacity);
    const glm::vec3 under = encoded(beneath);
    const glm::vec3 wanted = encoded(share * color + (1.0F - share) * beneath);
    double needed = std::max(opacity, least);
    for (int i = 0; i < 3; ++i) {
        const double step = wanted[i] - under[i];
        const double most = step > 0.0 ? 1.0 - under[i] : under[i];
        if (most > 0.0) needed = std::max(needed, std::abs(step) / most);
    }
    needed = std::min(needed, 1.0);
    const auto part = static_cast<float>(needed);
    return {glm::clamp((wanted - (1.0F - part) * under) / part, glm::vec3(0.0F), glm::vec3(1.0F)), needed};
}

std::vector<Strokes> seenOf(const Strokes& strokes, const Sight& sight, const PictureSize& size,
                            bool plotter) {
    return StrokeCutter(strokes, sight, size, plotter).cut();
}

}  // namespace mote::server
