// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/dot_maker.h"

#include <algorithm>
#include <optional>

#include "server/frames/layer_place.h"
#include "server/render/layers/hybrid/hybrid_load.h"

namespace mote::server {

bool DotHistory::settled() const {
    return std::all_of(layers.begin(), layers.end(),
                       [](const Layer& layer) { return layer.points.settled(); });
}

Status fitLayers(View& view, StepSource& source) {
    if (!view.cameraFitted) return success();
    std::optional<Bounds> all;
    for (std::size_t i = 0; i < view.layers.size(); ++i) {
        Bounds bounds = plotBounds;
        if (const auto* const style = view.layers[i].stipple()) {
            if (!style->image.empty() || style->sourceLayers) continue;  // lies on the screen
            const auto surface = source.surface(view.layers[i].dataset);
            if (!surface.ok()) return inLayer(i, surface.error());
            bounds = (*surface)->bounds();
        }
        if (view.layers[i].hybrid() != nullptr) {
            const auto place = source.place(view.layers[i].dataset);
            if (!place.ok()) return inLayer(i, place.error());
            if (place->manifest->kind() != "hybrid") continue;  // said when it is drawn
            bounds = render::hybridBounds(place->manifest->hybrid());
        }
        bounds = bounds.transformed(view.layers[i].transform);
        all = all ? all->united(bounds) : bounds;
    }
    if (all) view.camera = fitCamera(*all, view.aspect());
    return success();
}

Result<render::Dots> surfaceDots(const View& view, const Layer& layer, StepSource& source, bool onTheWay,
                                 DotHistory::Layer& history) {
    const auto surface = source.surface(layer.dataset);
    if (!surface.ok()) return surface.error();
    const StippleStyle& style = *layer.stipple();
    if (history.surface != *surface || !style.soft) history = {*surface, {}};
    const render::SurfaceDots dots(**surface, style, view, layer.transform);
    auto seen = dots.seen(dots.chosen());
    if (!style.soft) return dots.onScreen(seen);
    return dots.onScreen(onTheWay ? history.points.step(**surface, dots, std::move(seen))
                                  : history.points.settle(std::move(seen)));
}

}  // namespace mote::server
