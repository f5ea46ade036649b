// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/composite_frame.h"

#include <algorithm>
#include <cmath>

#include "server/render/blank_picture.h"

namespace mote::render {

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
             .visible = volumes[i],
             .pointColor = glm::vec3(layer.style.pointColor),
             .pointTau = static_cast<float>(-std::log1p(-layer.style.pointOpacity * size * size))});
    }
}

}  // namespace mote::render
