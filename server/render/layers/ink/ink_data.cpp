// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/ink_data.h"

#include <cmath>
#include <cstddef>

#include "protocol/base/mote_check.h"
#include "server/render/layers/hybrid/lower_hybrid.h"

namespace mote::render {
namespace {

/// A surface where a curve begins to count, and no haze before it.
Curve steep(const Curve& curve) {
    constexpr double counts = 0.25, solid = 0.97;  // of the greatest opacity; opacity
    constexpr double ramp = 0.01;                  // of the way between a curve's ends, on both sides
    const auto& knots = curve.knots();
    const double level = counts * curve.maximum(), half = ramp * (knots.back().x - knots.front().x);
    for (std::size_t i = 1; i < knots.size(); ++i) {
        const auto &from = knots[i - 1], &to = knots[i];
        if (!(from.y < level && to.y >= level)) continue;
        const double at = std::lerp(from.x, to.x, (level - from.y) / (to.y - from.y));
        return Curve::create({{at - half, 0.0}, {at + half, solid}}, -Curve::largest, Curve::largest).value();
    }
    return curve;
}

TransferFunction densityTransfer(const InkStyle& style) {
    auto particles = particlesStyleOf(parseParticlesStyle({}).value());
    particles.volumeOpacity = style.opacity ? *style.opacity : steep(particles.volumeOpacity);
    return particles.transfer();
}

}  // namespace

InkData inkDataOf(const Layer& layer, const LayerData& data) {
    if (data.mesh) return data.mesh;
    const auto style = inkStyleOf(*layer.ink());
    if (data.density) return InkVolume{data.density, densityTransfer(style), layer.clips()};
    MOTE_CHECK(data.hybrid != nullptr);
    return InkVolume{data.hybrid, inkTransfer(style, *data.hybrid, false), layer.clips()};
}

TransferFunction inkTransfer(const InkStyle& style, const GridField& field, bool density) {
    if (density) return densityTransfer(style);
    auto hybrid = hybridStyleOf(parseHybridStyle({}).value());
    hybrid.opacity = style.opacity ? *style.opacity : steep(defaultOpacity(field));
    return transferOf(hybrid, field);
}

Bounds boundsOf(const InkData& data) {
    if (const auto* const mesh = std::get_if<std::shared_ptr<const MeshSurface>>(&data))
        return (*mesh)->bounds();
    return std::get<InkVolume>(data).field->bounds();
}

}  // namespace mote::render
