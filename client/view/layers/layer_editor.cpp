// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/layer_editor.h"

#include "client/view/layers/hybrid_editor.h"
#include "client/view/layers/particles_editor.h"
#include "client/view/layers/stipple_editor.h"

namespace mote::client {
namespace {

struct Kind {
    proto::Layer::KindCase kind;
    std::unique_ptr<LayerEditor> (*make)();
};

template <class Editor>
std::unique_ptr<LayerEditor> make() {
    return std::make_unique<Editor>();
}

constexpr Kind kinds[] = {
    {proto::Layer::kParticles, make<ParticlesEditor>},
    {proto::Layer::kHybrid, make<HybridEditor>},
    {proto::Layer::kStipple, make<StippleEditor>},
};

}  // namespace

std::unique_ptr<LayerEditor> makeLayerEditor(proto::Layer::KindCase kind) {
    for (const auto& each : kinds) {
        if (each.kind == kind) return each.make();
    }
    return nullptr;
}

Bounds LayerEditor::bounds(const proto::Manifest& manifest) const {
    const auto& mesh = manifest.mesh();
    if (mesh.bounds_min_size() != 3 || mesh.bounds_max_size() != 3) return plotBounds;
    return {{mesh.bounds_min(0), mesh.bounds_min(1), mesh.bounds_min(2)},
            {mesh.bounds_max(0), mesh.bounds_max(1), mesh.bounds_max(2)}};
}

}  // namespace mote::client
