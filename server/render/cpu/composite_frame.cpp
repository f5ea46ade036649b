// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/composite_frame.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "server/render/blank_picture.h"
#include "server/render/screen_map.h"

namespace mote::render {
namespace {

/// Around the box's projection; all there is where that is unbounded, since the box reaches behind the eye.
PixelRange screenOf(const FramePlan& plan, const LayerPlan& layer) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    constexpr double margin = 1.0;  // for rounding
    const glm::dmat4 toScreen = boxToScreen(plan, layer);
    PixelRange range{glm::dvec2(infinite), glm::dvec2(-infinite)};
    for (unsigned i = 0; i < 8; ++i) {
        const glm::dvec4 corner = toScreen * glm::dvec4(i & 1U, i >> 1 & 1U, i >> 2 & 1U, 1.0);
        if (!(corner.w > 0.0)) return {glm::dvec2(-infinite), glm::dvec2(infinite)};
        const glm::dvec2 at(corner.x / corner.w, corner.y / corner.w);
        range = {glm::min(range.low, at - margin), glm::max(range.high, at + margin)};
    }
    return range;
}

}  // namespace

CompositeFrame::CompositeFrame(const FramePlan& plan, PixelFormat chosen,
                               const std::vector<VisibleVolume>& volumes)
    : width(plan.width),
      height(plan.height),
      slabs(plan.slabs),
      samplesPerCell(static_cast<float>(std::clamp(plan.samplesPerCell, 0.25, 64.0))),
      cellByCell(plan.samplesPerCell >= 2.0),
      window(plan.camera.halfHeight() * plan.width / plan.height, plan.camera.halfHeight()),
      background(plan.background),
      format(chosen),
      blank(blankPixel(plan.background, chosen)) {
    for (std::size_t i = 0; i < plan.layers.size(); ++i) {
        const LayerPlan& layer = plan.layers[i];
        const double size = std::min(layer.style.pointSize, 1.0);
        layers.push_back(
            {.rays = RayMap(plan, layer),
             .screen = screenOf(plan, layer),
             .visible = volumes[i],
             .pointColor = glm::vec3(layer.style.pointColor),
             .pointTau = static_cast<float>(-std::log1p(-layer.style.pointOpacity * size * size))});
    }
}

}  // namespace mote::render
