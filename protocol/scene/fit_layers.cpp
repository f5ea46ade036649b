// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/fit_layers.h"

#include "protocol/scene/mote_check.h"

namespace mote {

bool isFitted(const Layer& layer) {
    const bool onScreen = layer.stipple() != nullptr && layer.stipple()->onPlane();
    return !onScreen && layer.opacity > 0.0;
}

void fitLayers(View& view, std::span<const std::optional<Bounds>> boxes) {
    MOTE_CHECK(boxes.size() == view.layers.size());
    if (!view.cameraFitted) return;
    std::optional<Bounds> all;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        if (!boxes[i] || !isFitted(view.layers[i])) continue;
        const Bounds inWorld = boxes[i]->transformed(view.layers[i].transform);
        all = all ? all->united(inWorld) : inWorld;
    }
    if (all) view.camera = fitCamera(*all, view.aspect());
}

}  // namespace mote
