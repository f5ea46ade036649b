// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/fit_layers.h"

#include <algorithm>

#include "protocol/scene/mote_check.h"

namespace mote {
namespace {

/// What of a picture stays free for the labels of axes, on each side.
double marginOf(const View& view) {
    constexpr double labels = 4.5, most = 0.25;  // em; of the picture's shorter side
    if (!view.annotations || !view.annotations->axes) return 0.0;
    const double side = std::min(view.width, view.height);
    return std::min(most, labels * view.annotations->fontPixels(view.width, view.height, view.scale) / side);
}

Bounds grown(const Bounds& bounds, double factor) {
    const glm::dvec3 half = 0.5 * factor * bounds.size();
    return {bounds.center() - half, bounds.center() + half};
}

}  // namespace

bool isFitted(const Layer& layer) {
    const bool onScreen = layer.stipple() != nullptr && onPlane(*layer.stipple());
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
    if (all) view.camera = fitCamera(grown(*all, 1.0 / (1.0 - 2.0 * marginOf(view))), view.aspect());
}

}  // namespace mote
