// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/lower_ink.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <stop_token>
#include <utility>

#include "protocol/scene/ink_style.h"
#include "server/render/ink/drawing.h"
#include "server/render/ink/paint/wash.h"
#include "server/render/layers/ink/ink_data.h"
#include "server/render/layers/ink/line_view.h"
#include "server/render/layers/ink/mesh_lines.h"
#include "server/render/layers/ink/mesh_modalities.h"
#include "server/render/layers/ink/volume_lines.h"
#include "server/render/layers/ink/volume_modalities.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

// Pixels between places of a line at which what hides it is sought.
constexpr double sampling = 0.35;
constexpr double shortestSuggestive = 2.5;  // reading distances that a suggestive contour is long

/// Whether regions are painted to be inked: lines end there.
bool inksRegions(const InkStyle& style) {
    return std::any_of(style.regions.begin(), style.regions.end(),
                       [](const auto& region) { return region.fill == RegionFill::ink; });
}

/// Whether a drawing chooses lines by the depth steps beside them.
bool needsSteps(const InkStyle& style) {
    const auto mode = style.silhouettes.mode;
    return mode == SilhouetteMode::important || mode == SilhouetteMode::adjusted ||
           style.solid.strength > 0.0 || inksRegions(style);
}

/// Sees one kind of data or the other, the one place that asks for a kind (docs/INK.md, "What is seen" and
/// "Lines"); many threads work at it.
struct Seeing {
    const glm::dmat4& transform;
    const InkStyle& style;
    const FramePlan& plan;
    const bool lines;
    const std::stop_token& stop;

    InkScene operator()(const std::shared_ptr<const MeshSurface>& surface) const {
        auto seen = modalitiesOf(*surface, transform, style, plan, stop);
        InkScene scene;
        scene.modalities = std::move(seen.modalities);
        if (!lines) return scene;
        const LineView view(plan, transform);
        auto edges = linesOf(*surface, view, style.silhouettes.crease, stop);
        if (style.silhouettes.suggestive) {
            const auto more = suggestiveLines(*surface, view, stop);
            edges.insert(edges.end(), more.begin(), more.end());
        }
        if (!plan.exact) {
            scene.quick = true;
            scene.lines = quickLines(*surface, view, edges, scene.modalities, stop);
            return scene;
        }
        const auto pieces =
            visible(*surface, view, edges,
                    {.sampling = sampling, .likely = &seen.triangle, .farthest = &seen.farthest}, stop);
        scene.lines =
            chained(*surface, view, pieces,
                    needsSteps(style) ? std::optional(scene.modalities.extent) : std::nullopt, stop);
        return scene;
    }
    InkScene operator()(const InkVolume& volume) const {
        InkScene scene;
        scene.field = true;
        scene.modalities =
            modalitiesOf(volume, transform, style, plan, stop, lines ? &scene.lines : nullptr).modalities;
        return scene;
    }
};

/// The 3D stage; its lines only if they are asked for. `plan`: its size and its camera are told, and
/// whether it is exact. If `stop` is requested meanwhile something is missing.
InkScene seenOf(const InkData& data, const glm::dmat4& transform, const InkStyle& style,
                const FramePlan& plan, bool lines, const std::stop_token& stop) {
    auto scene = std::visit(Seeing{transform, style, plan, lines, stop}, data);
    scene.camera = {.toEye = plan.camera.worldToEye() * transform,
                    .perspective = plan.camera.perspective(),
                    .pixels = plan.height / (2.0 * plan.camera.halfHeight()),
                    .size = {plan.width, plan.height}};
    return scene;
}

bool needsLines(const InkStyle& style) {
    switch (style.show) {
        case InkPicture::drawing:
            return style.silhouettes.mode != SilhouetteMode::none || style.solid.strength > 0.0 ||
                   inksRegions(style);
        case InkPicture::edges:
        case InkPicture::complexity:
        case InkPicture::lighten:
        case InkPicture::darken:
            return true;
        default:
            return false;
    }
}

/// Short suggestive contours tell of noise, not of the form. `shortest`: pixels.
void dropShortSuggestive(std::vector<InkLine>& lines, double shortest) {
    std::erase_if(lines, [shortest](const InkLine& line) {
        double length = 0.0;
        for (std::size_t i = 0; i + 1 < line.points.size(); ++i)
            length += glm::distance(line.points[i].at, line.points[i + 1].at);
        return line.kind == LineKind::suggestive && length < shortest;
    });
}

/// What is washed: a surface at the depths of what is seen, and over nothing behind all of it.
class WashFragments : public FragmentMaker {
  public:
    /// `farthest`: depth of what lies over nothing. `opacity`: of the layer. `nearest`: depth from which on
    /// anything is seen.
    WashFragments(Raster<float> pigment, Raster<float> depth, const InkStyle& style, const glm::dvec3& paper,
                  double opacity, double nearest, double farthest)
        : pigment_(std::move(pigment)),
          depth_(std::move(depth)),
          style_(style.wash),
          inkIsDark_(style.inkIsDark),
          paper_(paper),
          opacity_(static_cast<float>(opacity)),
          nearest_(nearest),
          farthest_(farthest) {}

    void make(const PixelRect& pixels, Fragments& fragments) const override {
        for (std::uint32_t row = pixels.top; row < pixels.bottom; ++row) {
            for (std::uint32_t column = pixels.left; column < pixels.right; ++column) {
                const auto washed = onPaper(pigment_.at(column, row), style_, inkIsDark_, paper_);
                if (!washed || !(opacity_ * washed->opacity > 0.0F)) continue;
                const auto depth = static_cast<double>(depth_.at(column, row));
                fragments.push_back({.column = column,
                                     .row = row,
                                     .depth = std::isfinite(depth) ? std::max(depth, nearest_) : farthest_,
                                     .opacity = opacity_ * washed->opacity,
                                     .color = washed->color});
            }
        }
    }

  private:
    const Raster<float> pigment_, depth_;
    const WashStyle style_;
    const bool inkIsDark_;
    const glm::dvec3 paper_;
    const float opacity_;
    const double nearest_, farthest_;
};

/// A picture as a surface at the depths of what it shows; what shows nothing lies behind that.
Fragments fragmentsOf(const Raster<glm::vec3>& shown, const Modalities& modalities, double farthest,
                      float opacity) {
    Fragments fragments;
    if (!(opacity > 0.0F)) return fragments;
    fragments.reserve(shown.values.size());
    for (std::uint32_t row = 0; row < shown.height; ++row) {
        giveWay();
        for (std::uint32_t column = 0; column < shown.width; ++column) {
            const float depth = modalities.depth.at(column, row);
            fragments.push_back({.column = column,
                                 .row = row,
                                 .depth = std::isfinite(depth) ? static_cast<double>(depth) : farthest,
                                 .opacity = opacity,
                                 .color = shown.at(column, row)});
        }
    }
    return fragments;
}

}  // namespace

InkDrawing inkOf(const Layer& layer, const InkStyle& style, const InkData& data, const FramePlan& plan,
                 double pixels, const std::stop_token& stop, InkMemory* memory) {
    auto scene = seenOf(data, layer.transform, style, plan, needsLines(style), stop);
    if (isStopped(stop)) return {};
    if (!scene.quick) dropShortSuggestive(scene.lines, shortestSuggestive * style.reading * pixels);
    auto drawing = drawInk(scene, style, pixels, stop, memory);
    // It is drawn as if there were all of it, so that lines stay where they are while it fades.
    const auto opacity = drawing.strokes.opacity = static_cast<float>(layer.opacity);
    const Bounds inEye = boundsOf(data).transformed(plan.camera.worldToEye() * layer.transform);
    InkDrawing made{.strokes = std::move(drawing.strokes),
                    .fragments = {},
                    .wash = {},
                    .nearDepth = -inEye.max.z,
                    .farDepth = std::max(-inEye.min.z, nearLimit(plan.camera))};
    if (!drawing.shown.values.empty())
        made.fragments = fragmentsOf(drawing.shown, scene.modalities, made.farDepth, opacity);
    if (!drawing.pigment.values.empty())
        made.wash = std::make_shared<const WashFragments>(
            std::move(drawing.pigment), std::move(scene.modalities.depth), style, plan.background,
            layer.opacity, nearLimit(plan.camera), made.farDepth);
    return made;
}

std::optional<double> depthAt(const InkData& data, const glm::dmat4& transform, const InkStyle& style,
                              const FramePlan& plan, glm::dvec2 at) {
    if (const auto* const mesh = std::get_if<std::shared_ptr<const MeshSurface>>(&data))
        return depthAt(**mesh, transform, style, plan, at);
    return depthAt(std::get<InkVolume>(data), transform, style, plan, at);
}

void lowerInk(const Layer& layer, const InkStyle& style, const InkData& data, InkMemory* memory,
              Lowering& out) {
    auto ink = inkOf(layer, style, data, out.plan, out.pixels, out.stop, memory);
    if (!ink.fragments.empty()) {
        out.plan.fragments.push_back(std::make_shared<const Fragments>(std::move(ink.fragments)));
        out.addDots(ink.nearDepth, ink.farDepth);
    }
    if (ink.wash != nullptr) {
        out.addDots(ink.nearDepth, ink.farDepth);
        out.plan.surfaces.push_back(std::move(ink.wash));
    }
    if (!ink.strokes.empty())
        out.plan.strokes.push_back(std::make_shared<const Strokes>(std::move(ink.strokes)));
}

}  // namespace mote::render
