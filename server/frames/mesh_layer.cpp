// SPDX-License-Identifier: GPL-3.0-or-later
#include <glm/common.hpp>
#include <span>
#include <utility>

#include "server/data/load_mesh.h"
#include "server/frames/layer_kinds.h"

namespace mote::server {

/// Without the mesh there is nothing to be shown of it: a view in motion waits, too.
Result<LayerPart> meshPart(const LayerRequest& asked, const HalfSpaces& clips) {
    MOTE_ASSIGN_OR_RETURN(const auto entry, asked.data.dataset(asked.layer.dataset));
    const auto surface = asked.data.get(meshSurface(entry, clips));
    if (!surface.ok()) return surface.error();
    if (!*surface) return LayerPart();
    return LayerPart([surface = *surface](render::Scene& scene, std::size_t index, const auto&) {
        scene.layers[index].mesh = surface;
        // Nothing of it may be left.
        if (surface->mesh().triangles.empty()) scene.view.layers[index].opacity = 0.0;
        return DotHistory::Layer();
    });
}

Result<bool> shownOf(const MeshStyle&, const ShownLayer& shown, StepSource& data, CameraFit& fit) {
    MOTE_ASSIGN_OR_RETURN(const auto entry, data.dataset(shown.layer.dataset));
    MOTE_ASSIGN_OR_RETURN(const auto surface, data.get(meshSurface(entry)));
    if (!surface) return false;
    const auto& mesh = surface->mesh();
    const auto clips = shown.layer.clips();
    if (clips.empty()) {
        for (const auto& place : mesh.positions) fit.add(glm::dvec3(place));
    }
    for (const auto& edge : clips.empty() ? std::span<const storage::MeshEdge>() : std::span(mesh.edges)) {
        const glm::dvec3 from(mesh.positions[edge.vertices[0]]), to(mesh.positions[edge.vertices[1]]);
        double enter = 0.0, leave = 1.0;
        clipWay(clips, from, to - from, enter, leave);
        if (!(enter <= leave)) continue;
        fit.add(glm::mix(from, to, enter));
        fit.add(glm::mix(from, to, leave));
    }
    return true;
}

Result<LayerPart> partOf(const MeshStyle&, const LayerRequest& asked) {
    return meshPart(asked);
}

}  // namespace mote::server
