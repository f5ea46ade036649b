// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/ink_data.h"

#include "protocol/scene/mote_check.h"
#include "server/render/layers/hybrid/lower_hybrid.h"

namespace mote::render {
namespace {

template <class T>
std::shared_ptr<const T> held(const std::vector<std::shared_ptr<const T>>& layers, std::size_t index) {
    return index < layers.size() ? layers[index] : nullptr;
}

TransferFunction densityTransfer(const InkStyle& style) {
    auto particles = parseParticlesStyle({}).value();
    if (style.opacity) particles.volumeOpacity = *style.opacity;
    return particles.transfer();
}

}  // namespace

InkData inkDataOf(const Scene& scene, std::size_t index) {
    const auto style = inkStyleOf(*scene.view.layers[index].ink());
    if (auto mesh = held(scene.meshes, index)) return mesh;
    if (auto density = held(scene.densities, index))
        return InkVolume{std::move(density), densityTransfer(style), scene.view.layers[index].clips()};
    auto volume = held(scene.hybrids, index);
    MOTE_CHECK(volume != nullptr);
    return InkVolume{volume, inkTransfer(style, *volume, false), scene.view.layers[index].clips()};
}

TransferFunction inkTransfer(const InkStyle& style, const GridField& field, bool density) {
    if (density) return densityTransfer(style);
    auto hybrid = hybridStyleOf(parseHybridStyle({}).value());
    hybrid.opacity = style.opacity;
    return transferOf(hybrid, field);
}

Bounds boundsOf(const InkData& data) {
    if (const auto* const mesh = std::get_if<std::shared_ptr<const MeshSurface>>(&data))
        return (*mesh)->bounds();
    return std::get<InkVolume>(data).field->bounds();
}

}  // namespace mote::render
