// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <utility>

#include "server/data/load_hybrid.h"
#include "server/data/load_mesh.h"
#include "server/frames/layer_kinds.h"
#include "server/render/layers/hybrid/lower_hybrid.h"
#include "server/render/layers/ink/ink_data.h"

namespace mote::server {
namespace {

Result<LayerPart> inkOfMesh(const proto::InkStyle& style, const storage::Catalogue::Entry& entry,
                            const LayerRequest& asked) {
    if (!style.curve().empty()) {
        return Error{ErrorCode::invalidArgument, "ink.curve",
                     fmt::format("a curve is of a volume or of particles, and \"{}\" is a mesh", entry.name)};
    }
    return meshPart(asked, asked.layer.clips());
}

Result<LayerPart> inkOfParticles(const storage::Catalogue::Entry& entry, const LayerRequest& asked) {
    const auto found = asked.data.get(stepDensity(entry, asked.layer.step));
    if (!found.ok()) return found.error();
    if (!*found) return LayerPart();
    return LayerPart([density = *found](render::Scene& scene, std::size_t index, const auto&) {
        scene.layers[index].density = density;
        return DotHistory::Layer();
    });
}

/// What a layer's ink is drawn of.
std::shared_ptr<const void> drawnOf(const render::LayerData& data) {
    if (data.mesh) return data.mesh;
    return data.density ? data.density : data.hybrid;
}

/// A coherent drawing remembers what it drew while it draws the same.
LayerPart coherent(LayerPart part) {
    return [part = std::move(part)](render::Scene& scene, std::size_t index, DotHistory::Layer before) {
        part(scene, index, {});
        const auto drawn = drawnOf(scene.layers[index]);
        if (before.ink == nullptr || before.inked.lock() != drawn)
            before = {.inked = drawn, .ink = std::make_shared<render::InkMemory>()};
        scene.layers[index].ink = before.ink;
        return before;
    };
}

Result<LayerPart> inkOf(const proto::InkStyle& style, const storage::Catalogue::Entry& entry,
                        const LayerRequest& asked) {
    const auto& kind = entry.manifest->kind();
    if (hasMesh(*entry.manifest) || kind == "stipple") return inkOfMesh(style, entry, asked);
    if (kind == "hybrid") return hybridPart(HybridRepresentation::best, asked);
    if (kind == "particles") return inkOfParticles(entry, asked);
    return Error{
        ErrorCode::invalidArgument, "dataset",
        fmt::format("\"{}\" is of kind \"{}\", not a mesh, a hybrid volume or particles", entry.name, kind)};
}

}  // namespace

Result<bool> shownOf(const proto::InkStyle& style, const ShownLayer& shown, StepSource& data,
                     CameraFit& fit) {
    MOTE_ASSIGN_OR_RETURN(const auto entry, data.dataset(shown.layer.dataset));
    const auto& kind = entry.manifest->kind();
    // That a dataset is of another kind is said when it is drawn.
    if (hasMesh(*entry.manifest)) return shownOf(MeshStyle(), shown, data, fit);
    if (kind != "hybrid" && kind != "particles") return true;
    MOTE_ASSIGN_OR_RETURN(const auto field, data.get(kind == "hybrid" ? hybridStep(entry, shown.step,
                                                                                   HybridRepresentation::best)
                                                                      : stepDensity(entry, shown.step)));
    if (!field) return false;
    const auto ink = inkStyleOf(style, true);
    const auto transfer = render::inkTransfer(ink, *field, kind == "particles");
    render::addShown(*field, transfer, HybridRepresentation::best, fit);
    return true;
}

Result<LayerPart> partOf(const proto::InkStyle& style, const LayerRequest& asked) {
    MOTE_ASSIGN_OR_RETURN(const auto entry, asked.data.dataset(asked.layer.dataset));
    auto part = inkOf(style, entry, asked);
    if (!style.coherent() || !part.ok() || !*part) return part;
    return coherent(*std::move(part));
}

}  // namespace mote::server
