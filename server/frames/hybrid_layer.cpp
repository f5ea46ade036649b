// SPDX-License-Identifier: GPL-3.0-or-later
#include <utility>

#include "server/data/load_hybrid.h"
#include "server/frames/layer_kinds.h"
#include "server/render/layers/hybrid/lower_hybrid.h"

namespace mote::server {

/// A view in motion is drawn from the volume alone where the rest is not there; but while a series is played
/// and no hand is on the view, each step is worth waiting for.
Result<LayerPart> hybridPart(HybridRepresentation representation, const LayerRequest& asked) {
    MOTE_ASSIGN_OR_RETURN(const auto entry, asked.data.dataset(asked.layer.dataset));
    auto found = asked.data.get(hybridStep(entry, asked.layer.step, representation));
    const bool inMotion = asked.job.stage != Stage::exact;
    if (found.ok() && !*found && inMotion && (asked.job.task->moving || !asked.data.played(entry)))
        found = asked.data.get(hybridVolume(entry, asked.layer.step));
    if (!found.ok()) return found.error();
    if (!*found) return LayerPart();
    return LayerPart([step = *std::move(found)](render::Scene& scene, std::size_t index, const auto&) {
        scene.layers[index].hybrid = step;
        return DotHistory::Layer();
    });
}

Result<bool> shownOf(const proto::HybridStyle& message, const ShownLayer& shown, StepSource& data,
                     CameraFit& fit) {
    const auto style = hybridStyleOf(message);
    MOTE_ASSIGN_OR_RETURN(const auto entry, data.dataset(shown.layer.dataset));
    MOTE_ASSIGN_OR_RETURN(const auto field, data.get(hybridStep(entry, shown.step, style.representation)));
    if (!field) return false;
    render::addShown(*field, render::transferOf(style, *field), style.representation, fit);
    return true;
}

Result<LayerPart> partOf(const proto::HybridStyle& style, const LayerRequest& asked) {
    return hybridPart(hybridStyleOf(style).representation, asked);
}

}  // namespace mote::server
