// SPDX-License-Identifier: GPL-3.0-or-later
#include <utility>

#include "server/data/load_mesh.h"
#include "server/frames/layer_kinds.h"

namespace mote::server {

/// Without the mesh there is nothing to be shown of it: a view in motion waits, too.
Result<LayerPart> meshPart(const LayerRequest& asked) {
    MOTE_ASSIGN_OR_RETURN(const auto entry, asked.data.dataset(asked.layer.dataset));
    const auto surface = asked.data.get(meshSurface(entry));
    if (!surface.ok()) return surface.error();
    if (!*surface) return LayerPart();
    return LayerPart([surface = *surface](render::Scene& scene, std::size_t index, const auto&) {
        scene.meshes.resize(scene.view.layers.size());
        scene.meshes[index] = surface;
        return DotHistory::Layer();
    });
}

Result<bool> shownOf(const MeshStyle&, const ShownLayer& shown, StepSource& data, CameraFit& fit) {
    MOTE_ASSIGN_OR_RETURN(const auto entry, data.dataset(shown.layer.dataset));
    MOTE_ASSIGN_OR_RETURN(const auto surface, data.get(meshSurface(entry)));
    if (!surface) return false;
    for (const auto& place : surface->mesh().positions) fit.add(glm::dvec3(place));
    return true;
}

Result<LayerPart> partOf(const MeshStyle&, const LayerRequest& asked) {
    return meshPart(asked);
}

}  // namespace mote::server
