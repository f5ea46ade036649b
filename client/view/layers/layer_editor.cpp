// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/layer_editor.h"

#include "client/view/layers/hybrid_editor.h"
#include "client/view/layers/image_editor.h"
#include "client/view/layers/ink_editor.h"
#include "client/view/layers/mesh_editor.h"
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
    {proto::Layer::kMesh, make<MeshEditor>},
    {proto::Layer::kInk, make<InkEditor>},
    {proto::Layer::kImage, make<ImageEditor>},
};

}  // namespace

std::unique_ptr<LayerEditor> makeLayerEditor(proto::Layer::KindCase kind) {
    for (const auto& each : kinds) {
        if (each.kind == kind) return each.make();
    }
    return nullptr;
}

}  // namespace mote::client
