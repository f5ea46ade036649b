// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/annotation_facts.h"

#include "server/figures/annotate.h"

namespace mote::server {

std::shared_ptr<const Marks> annotationsOf(const render::Scene& scene, const render::FramePlan& plan,
                                           StepSource& data) {
    const View& view = scene.view;
    if (!view.annotations) return nullptr;
    std::vector<LayerFacts> layers(view.layers.size());
    for (std::size_t i = 0; i < layers.size(); ++i) {
        const Layer& layer = view.layers[i];
        if (const auto found = data.dataset(layer.dataset); found.ok()) layers[i].manifest = found->manifest;
        if (!layer.particles() || scene.steps[i] == nullptr) continue;
        if (layer.select) layers[i].chosen = scene.steps[i]->pointCount();
        const bool highlighted =
            layer.highlight && i < scene.highlights.size() && scene.highlights[i] != nullptr;
        if (highlighted) layers[i].highlighted = scene.highlights[i]->pointCount();
        if (layer.colorBy) layers[i].colorRange = layer.colorBy->range;
    }
    for (const auto& field : plan.fields) {
        // Where a column colours the volume, the bar is the column's alone.
        const auto* const cells = field.density();
        if (cells == nullptr || cells->values == nullptr) layers[field.layer].transfer = field.transfer;
    }
    return std::make_shared<const Marks>(annotate(view, layers));
}

}  // namespace mote::server
