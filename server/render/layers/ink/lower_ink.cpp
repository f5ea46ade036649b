// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/lower_ink.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/render/ink/drawing.h"
#include "server/render/layers/ink/ink_seen.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

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
    const auto scene = seenOf(data, layer.transform, style, plan, needsLines(style), stop);
    if (isStopped(stop)) return {};
    auto drawing = drawInk(scene, style, pixels, stop, memory);
    // It is drawn as if there were all of it, so that lines stay where they are while it fades.
    const auto opacity = drawing.strokes.opacity = static_cast<float>(layer.opacity);
    const Bounds inEye = boundsOf(data).transformed(plan.camera.worldToEye() * layer.transform);
    InkDrawing made{.strokes = std::move(drawing.strokes),
                    .fragments = {},
                    .nearDepth = -inEye.max.z,
                    .farDepth = std::max(-inEye.min.z, nearLimit(plan.camera))};
    if (!drawing.shown.values.empty())
        made.fragments = fragmentsOf(drawing.shown, scene.modalities, made.farDepth, opacity);
    return made;
}

void lowerInk(const Layer& layer, const InkStyle& style, const InkData& data, InkMemory* memory,
              Lowering& out) {
    auto ink = inkOf(layer, style, data, out.plan, out.pixels, out.stop, memory);
    if (!ink.fragments.empty()) {
        out.plan.fragments.push_back(std::make_shared<const Fragments>(std::move(ink.fragments)));
        out.addDots(ink.nearDepth, ink.farDepth);
    }
    if (!ink.strokes.empty())
        out.plan.strokes.push_back(std::make_shared<const Strokes>(std::move(ink.strokes)));
}

}  // namespace mote::render
