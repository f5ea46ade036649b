// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/lower_ink.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/render/ink/drawing.h"
#include "server/render/layers/ink/line_view.h"
#include "server/render/layers/ink/mesh_lines.h"
#include "server/render/layers/ink/mesh_modalities.h"
#include "server/render/layers/ink/quick_lines.h"

namespace mote::render {
namespace {

// Pixels between places of a line at which what hides it is sought.
constexpr double sampling = 0.35;

bool needsLines(const InkStyle& style) {
    switch (style.show) {
        case InkPicture::drawing:
            return style.silhouettes.mode != SilhouetteMode::none || style.solid.strength > 0.0;
        case InkPicture::edges:
        case InkPicture::complexity:
        case InkPicture::lighten:
        case InkPicture::darken:
            return true;
        default:
            return false;
    }
}

InkCamera cameraOf(const FramePlan& plan, const glm::dmat4& transform) {
    return {.toEye = plan.camera.worldToEye() * transform,
            .perspective = plan.camera.perspective(),
            .pixels = plan.height / (2.0 * plan.camera.halfHeight()),
            .size = {plan.width, plan.height}};
}

/// The 3D stage.
InkScene sceneOf(const Layer& layer, const InkStyle& style, const MeshSurface& surface, const FramePlan& plan,
                 const std::stop_token& stop) {
    auto seen = modalitiesOf(surface, layer.transform, style, plan, stop);
    InkScene scene{std::move(seen.modalities), {}, cameraOf(plan, layer.transform)};
    if (!needsLines(style)) return scene;
    const LineView view(plan, layer.transform);
    const auto edges = linesOf(surface, view, style.silhouettes.crease, stop);
    if (!plan.exact) {
        scene.quick = true;
        scene.lines = quickLines(surface, view, edges, scene.modalities, stop);
        return scene;
    }
    const auto pieces =
        visible(surface, view, edges,
                {.sampling = sampling, .likely = &seen.triangle, .farthest = &seen.farthest}, stop);
    scene.lines = chained(surface, view, pieces, scene.modalities.extent, stop);
    return scene;
}

/// A picture as a surface at the depths of what it shows; what shows nothing lies behind that.
Fragments fragmentsOf(const Raster<glm::vec3>& shown, const Modalities& modalities, double farthest) {
    Fragments fragments;
    fragments.reserve(shown.values.size());
    for (std::uint32_t row = 0; row < shown.height; ++row) {
        for (std::uint32_t column = 0; column < shown.width; ++column) {
            const float depth = modalities.depth.at(column, row);
            fragments.push_back({.column = column,
                                 .row = row,
                                 .depth = std::isfinite(depth) ? static_cast<double>(depth) : farthest,
                                 .opacity = 1.0F,
                                 .color = shown.at(column, row)});
        }
    }
    return fragments;
}

}  // namespace

InkDrawing inkOf(const Layer& layer, const InkStyle& style, const MeshSurface& surface, const FramePlan& plan,
                 double pixels, const std::stop_token& stop, InkMemory* memory) {
    const auto scene = sceneOf(layer, style, surface, plan, stop);
    if (stop.stop_requested()) return {};
    auto drawing = drawInk(scene, style, pixels, stop, memory);
    const Bounds inEye = surface.bounds().transformed(plan.camera.worldToEye() * layer.transform);
    InkDrawing made{.strokes = std::move(drawing.strokes),
                    .fragments = {},
                    .nearDepth = -inEye.max.z,
                    .farDepth = std::max(-inEye.min.z, nearLimit(plan.camera))};
    if (!drawing.shown.values.empty())
        made.fragments = fragmentsOf(drawing.shown, scene.modalities, made.farDepth);
    return made;
}

void lowerInk(const Layer& layer, const InkStyle& style, const MeshSurface& surface, InkMemory* memory,
              Lowering& out) {
    auto ink = inkOf(layer, style, surface, out.plan, out.pixels, out.stop, memory);
    if (!ink.fragments.empty()) {
        out.plan.fragments.push_back(std::make_shared<const Fragments>(std::move(ink.fragments)));
        out.addDots(ink.nearDepth, ink.farDepth);
    }
    if (!ink.strokes.empty())
        out.plan.strokes.push_back(std::make_shared<const Strokes>(std::move(ink.strokes)));
}

}  // namespace mote::render
