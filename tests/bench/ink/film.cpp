// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/ink/film.h"

#include <algorithm>
#include <cmath>

#include "server/render/ink/tone_grid.h"
#include "server/render/plan/stroke_fragments.h"

namespace mote::bench {

using namespace render;

namespace {

constexpr double inkBlur = 1.5;      // standard deviation, pixels: less than that is no flicker
constexpr double alikeDepth = 2e-3;  // of the extent

/// Strokes of a picture, in short steps, where the place on the surface is seen in another picture too; there
/// they are where they go with the surface.
struct SharedStrokes {
    Strokes here, there;

    SharedStrokes(const Strokes& strokes, const PictureMotion& motion, const Raster<float>& depthThere,
                  double alike) {
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
                        motion, depthThere, alike);
                }
            }
            end();
        }
    }

  private:
    static constexpr double step = 2.0;  // pixels

    void add(const StrokePoint& point, const PictureMotion& motion, const Raster<float>& depthThere,
             double alike) {
        const auto moved = motion({{point.x, point.y}, point.depth});
        bool seen = false;
        for (const double down : {-1.0, 0.0, 1.0}) {
            for (const double across : {-1.0, 0.0, 1.0}) {
                const glm::dvec2 at = moved.at + glm::dvec2(across, down);
                if (!(at.x >= 0.0 && at.y >= 0.0 && at.x < depthThere.width && at.y < depthThere.height))
                    continue;
                seen |= static_cast<double>(depthThere.near(at.x, at.y)) >= moved.depth - alike;
            }
        }
        if (!seen) return end();
        here.points.push_back(point);
        there.points.push_back(
            {static_cast<float>(moved.at.x), static_cast<float>(moved.at.y), point.width, moved.depth});
    }
    void end() {
        const auto begin = here.lines.empty() ? 0U : here.lines.back().end;
        const auto last = static_cast<std::uint32_t>(here.points.size());
        if (last == begin) return;
        here.lines.push_back({begin, last});
        there.lines.push_back({begin, last});
    }
};

/// Lines, which are the first strokes, at the depths of their edges: a pen brings them nearer.
Strokes onSurface(const Strokes& strokes, const std::vector<InkLine>& lines) {
    Strokes made = strokes;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        const float width = strokes.points[strokes.lines[i].begin].width;
        const auto begin = static_cast<std::uint32_t>(made.points.size());
        for (const auto& point : lines[i].points)
            made.points.push_back(
                {static_cast<float>(point.at.x), static_cast<float>(point.at.y), width, point.depth});
        made.lines[i] = {begin, static_cast<std::uint32_t>(made.points.size())};
    }
    return made;
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
        const SharedStrokes then(strokes_, PictureMotion(camera_, scene.camera), modalities.depth, alike);
        const SharedStrokes now(strokes, PictureMotion(scene.camera, camera_), depth_, alike);
        const auto was = blurred(coverOf(then.there, plan), inkBlur);
        const auto is = blurred(coverOf(now.here, plan), inkBlur);
        for (std::size_t i = 0; i < is.values.size(); ++i) {
            changed_ += std::abs(static_cast<double>(is.values[i]) - static_cast<double>(was.values[i]));
            inked_ += 0.5 * (static_cast<double>(is.values[i]) + static_cast<double>(was.values[i]));
        }
    }
    strokes_ = strokes;
    depth_ = modalities.depth;
    camera_ = scene.camera;
}
}  // namespace mote::bench
