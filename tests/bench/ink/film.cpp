// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/ink/film.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "server/render/ink/tone_grid.h"
#include "server/render/plan/stroke_fragments.h"

namespace mote::bench {

using namespace render;

namespace {

constexpr double inkBlur = 1.5;      // standard deviation, pixels: less than that is no flicker
constexpr double alikeDepth = 2e-3;  // of the extent
constexpr double outerStep = 0.999;  // of a line beside nothing

/// Strokes in short steps, each with where it goes with the surface.
class MovedStrokes {
  public:
    MovedStrokes(const FilmStrokes& all, const PictureMotion& motion) {
        const auto& strokes = all.strokes;
        for (const auto& line : strokes.lines) {
            for (auto i = line.begin; i < line.end; ++i) {
                const auto& from = strokes.points[i];
                const auto& to = strokes.points[std::min(i + 1, line.end - 1)];
                const int count = std::max(
                    1, static_cast<int>(std::hypot(to.x - from.x, to.y - from.y) / static_cast<float>(step)));
                for (int k = 0; k < count; ++k) {
                    const float share = static_cast<float>(k) / static_cast<float>(count);
                    add({std::lerp(from.x, to.x, share), std::lerp(from.y, to.y, share),
                         std::lerp(from.width, to.width, share),
                         std::lerp(from.depth, to.depth, static_cast<double>(share))},
                        all.parts[i], motion);
                }
            }
            begins_.push_back(static_cast<std::uint32_t>(here_.size()));
        }
    }

    /// Which of them are seen where they go, or a pixel beside it.
    std::vector<bool> seenIn(const Raster<float>& depth, double alike) const {
        std::vector<bool> seen(moved_.size());
        for (std::size_t i = 0; i < moved_.size(); ++i) {
            for (const double down : {-1.0, 0.0, 1.0}) {
                for (const double across : {-1.0, 0.0, 1.0}) {
                    const glm::dvec2 at = moved_[i].at + glm::dvec2(across, down);
                    if (!(at.x >= 0.0 && at.y >= 0.0 && at.x < depth.width && at.y < depth.height)) continue;
                    seen[i] =
                        seen[i] || static_cast<double>(depth.near(at.x, at.y)) >= moved_[i].depth - alike;
                }
            }
        }
        return seen;
    }
    /// Which of them nothing hides within a pixel, neither where they are nor where they go: whether they are
    /// seen is no matter of a pixel's rounding.
    std::vector<bool> inFrontOfAll(const Raster<float>& here, const Raster<float>& there,
                                   double alike) const {
        std::vector<bool> seen(moved_.size());
        for (std::size_t i = 0; i < moved_.size(); ++i) {
            const PicturePlace at{{here_[i].x, here_[i].y}, here_[i].depth};
            seen[i] = isFree(here, at, alike) && isFree(there, moved_[i], alike);
        }
        return seen;
    }
    /// What of them `seen` says, as they are or where they go.
    FilmStrokes those(const std::vector<bool>& seen, bool there) const {
        FilmStrokes made;
        std::size_t next = 0;
        std::uint32_t begin = 0;
        const auto end = [&] {
            const auto last = static_cast<std::uint32_t>(made.strokes.points.size());
            if (last > begin) made.strokes.lines.push_back({begin, last});
            begin = last;
        };
        for (std::size_t i = 0; i < here_.size(); ++i) {
            while (next < begins_.size() && begins_[next] <= i) {
                end();
                ++next;
            }
            if (!seen[i]) {
                end();
                continue;
            }
            auto point = here_[i];
            if (there)
                point = {static_cast<float>(moved_[i].at.x), static_cast<float>(moved_[i].at.y), point.width,
                         moved_[i].depth};
            made.strokes.points.push_back(point);
            made.parts.push_back(parts_[i]);
        }
        end();
        return made;
    }

  private:
    static constexpr double step = 2.0;  // pixels

    static bool isFree(const Raster<float>& depth, const PicturePlace& place, double alike) {
        for (const double down : {-1.0, 0.0, 1.0}) {
            for (const double across : {-1.0, 0.0, 1.0}) {
                const glm::dvec2 at = place.at + glm::dvec2(across, down);
                if (!(at.x >= 0.0 && at.y >= 0.0 && at.x < depth.width && at.y < depth.height)) return false;
                if (static_cast<double>(depth.near(at.x, at.y)) < place.depth - alike) return false;
            }
        }
        return true;
    }
    void add(const StrokePoint& point, InkPart part, const PictureMotion& motion) {
        here_.push_back(point);
        moved_.push_back(motion({{point.x, point.y}, point.depth}));
        parts_.push_back(part);
    }

    std::vector<StrokePoint> here_;
    std::vector<PicturePlace> moved_;
    std::vector<InkPart> parts_;
    std::vector<std::uint32_t> begins_;  // of the strokes after the first
};

InkPart partOf(const InkLine& line, const LinePoint& point) {
    if (point.step >= outerStep) return InkPart::outer;
    switch (line.kind) {
        case LineKind::silhouette:
            return InkPart::silhouette;
        case LineKind::border:
            return InkPart::border;
        default:
            return InkPart::crease;
    }
}

/// Lines, which are the first strokes, at the depths of their edges: a pen brings them nearer.
FilmStrokes onSurface(const Strokes& strokes, const std::vector<InkLine>& lines) {
    FilmStrokes made{strokes, std::vector<InkPart>(strokes.points.size(), InkPart::hatch)};
    auto& points = made.strokes.points;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        const float width = strokes.points[strokes.lines[i].begin].width;
        const auto begin = static_cast<std::uint32_t>(points.size());
        for (const auto& point : lines[i].points) {
            points.push_back(
                {static_cast<float>(point.at.x), static_cast<float>(point.at.y), width, point.depth});
            made.parts.push_back(partOf(lines[i], point));
        }
        made.strokes.lines[i] = {begin, static_cast<std::uint32_t>(points.size())};
    }
    return made;
}

/// Those of one kind.
Strokes only(const FilmStrokes& all, InkPart part) {
    Strokes made;
    for (const auto& line : all.strokes.lines) {
        for (auto i = line.begin; i < line.end; ++i) {
            if (all.parts[i] != part) continue;
            const auto begin = static_cast<std::uint32_t>(made.points.size());
            made.points.push_back(all.strokes.points[i]);
            if (i + 1 < line.end) made.points.push_back(all.strokes.points[i + 1]);
            made.lines.push_back({begin, static_cast<std::uint32_t>(made.points.size())});
        }
    }
    return made;
}

struct Change {
    double changed = 0.0, inked = 0.0;
};

Change changeOf(const Raster<float>& was, const Raster<float>& is) {
    Change change;
    for (std::size_t i = 0; i < is.values.size(); ++i) {
        change.changed += std::abs(static_cast<double>(is.values[i]) - static_cast<double>(was.values[i]));
        change.inked += 0.5 * (static_cast<double>(is.values[i]) + static_cast<double>(was.values[i]));
    }
    return change;
}

}  // namespace

/// The share of each pixel that ink covers.
Raster<float> coverOf(const Strokes& strokes, const FramePlan& plan) {
    Raster<float> bare(plan.width, plan.height, 1.0F);
    for (const auto& part : strokeFragments(strokes, plan.width, plan.height, 0.0)) {
        for (const auto& one : part) bare.at(one.column, one.row) *= 1.0F - one.opacity;
    }
    for (auto& value : bare.values) value = 1.0F - value;
    return bare;
}

void Film::show(const InkScene& scene, const Drawing& drawing, const InkMemory& memory,
                const FramePlan& plan) {
    const auto& modalities = scene.modalities;
    const auto strokes = onSurface(drawing.strokes, memory.drawn);
    if (!depth_.values.empty()) {
        const double alike = alikeDepth * modalities.extent;
        const MovedStrokes before(before_, PictureMotion(camera_, scene.camera)),
            after(strokes, PictureMotion(scene.camera, camera_));
        const auto seenNow = before.seenIn(modalities.depth, alike), seenBefore = after.seenIn(depth_, alike);
        const auto then = before.those(seenNow, true), now = after.those(seenBefore, false);
        const auto was = blurred(coverOf(then.strokes, plan), inkBlur);
        const auto is = blurred(coverOf(now.strokes, plan), inkBlur);
        const auto all = changeOf(was, is);
        changed_ += all.changed;
        inked_ += all.inked;
        if (compared) compared(was, is);
        const auto front = changeOf(
            blurred(coverOf(before.those(before.inFrontOfAll(depth_, modalities.depth, alike), true).strokes,
                            plan),
                    inkBlur),
            blurred(coverOf(after.those(after.inFrontOfAll(modalities.depth, depth_, alike), false).strokes,
                            plan),
                    inkBlur));
        changedInFront_ += front.changed;
        inkedInFront_ += front.inked;
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            const auto part = static_cast<InkPart>(i);
            const auto one = changeOf(blurred(coverOf(only(then, part), plan), inkBlur),
                                      blurred(coverOf(only(now, part), plan), inkBlur));
            parts_[i].changed += one.changed;
            parts_[i].inked += one.inked;
        }
    }
    ink_ = 0.0;
    for (const float value : coverOf(drawing.strokes, plan).values) ink_ += static_cast<double>(value);
    before_ = strokes;
    depth_ = modalities.depth;
    camera_ = scene.camera;
}

}  // namespace mote::bench
