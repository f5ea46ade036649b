// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/flat_layer.h"

namespace mote::render {

std::optional<std::uint32_t> flatLayer(const FramePlan& plan, const std::vector<VisibleVolume>& volumes) {
    if (plan.anyDots() || !plan.hybrids.empty()) return std::nullopt;
    std::optional<std::uint32_t> only;
    for (std::uint32_t i = 0; i < plan.layers.size(); ++i) {
        if (volumes[i].volume != nullptr) return std::nullopt;
        if (plan.layers[i].pointsDrawn == 0) continue;
        if (only) return std::nullopt;
        only = i;
    }
    return only;
}

}  // namespace mote::render
