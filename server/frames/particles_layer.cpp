// SPDX-License-Identifier: GPL-3.0-or-later
#include <utility>

#include "server/frames/layer_kinds.h"

namespace mote::server {

Result<LayerPart> partOf(const ParticlesStyle&, const LayerRequest& asked) {
    MOTE_ASSIGN_OR_RETURN(auto found, asked.data.step(asked.layer.dataset, asked.layer.step));
    return LayerPart([step = std::move(found)](render::Scene& scene, std::size_t index, const auto&) {
        ParticlesStyle& style = *scene.view.layers[index].particles();
        if (style.opacityByPlot) style.pointOpacity = defaultPointOpacity(step->pointCount());
        scene.steps[index] = step;
        return DotHistory::Layer();
    });
}

}  // namespace mote::server
