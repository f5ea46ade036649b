// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <utility>

#include "protocol/scene/dataset.h"
#include "server/data/load_density.h"
#include "server/data/load_mesh.h"
#include "server/frames/layer_kinds.h"

namespace mote::server {
namespace {

Result<LayerPart> inkOfMesh(const InkStyle& style, const storage::Catalogue::Entry& entry,
                            const LayerRequest& asked) {
    if (style.opacity) {
        return Error{ErrorCode::invalidArgument, "ink.curve",
                     fmt::format("a curve is of a volume or of particles, and \"{}\" is a mesh", entry.name)};
    }
    return meshPart(asked);
}

Result<LayerPart> inkOfParticles(const storage::Catalogue::Entry& entry, const LayerRequest& asked) {
    const auto found = asked.data.get(stepDensity(entry, asked.layer.step));
    if (!found.ok()) return found.error();
    if (!*found) return LayerPart();
    return LayerPart([density = *found](render::Scene& scene, std::size_t index, const auto&) {
        scene.densities.resize(scene.view.layers.size());
        scene.densities[index] = density;
        return DotHistory::Layer();
    });
}

/// Kinds of datasets that ink is drawn of.
bool drawn(const proto::Manifest& manifest) {
    const auto& kind = manifest.kind();
    return kind == "mesh" || kind == "hybrid" || kind == "particles";
}

}  // namespace

Result<LayerPart> partOf(const InkStyle& style, const LayerRequest& asked) {
    MOTE_ASSIGN_OR_RETURN(const auto entry, asked.data.dataset(asked.layer.dataset));
    const auto& kind = entry.manifest->kind();
    if (kind == "mesh") return inkOfMesh(style, entry, asked);
    if (kind == "hybrid") return hybridPart(HybridRepresentation::best, asked);
    if (kind == "particles") return inkOfParticles(entry, asked);
    return Error{
        ErrorCode::invalidArgument, "dataset",
        fmt::format("\"{}\" is of kind \"{}\", not a mesh, a hybrid volume or particles", entry.name, kind)};
}

Result<std::optional<Bounds>> boundsOf(const InkStyle&, const Layer& layer, StepSource& data) {
    MOTE_ASSIGN_OR_RETURN(const auto entry, data.dataset(layer.dataset));
    if (!drawn(*entry.manifest)) return std::optional<Bounds>();
    return std::optional(datasetBounds(*entry.manifest));
}

}  // namespace mote::server
