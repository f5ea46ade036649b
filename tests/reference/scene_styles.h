// SPDX-License-Identifier: GPL-3.0-or-later
//
// How layers of particles of a scene are drawn, to be changed by a test. A pure function.
#pragma once

#include <algorithm>
#include <cstddef>

#include "protocol/scene/particles_style.h"
#include "server/render/layers/scene.h"

namespace mote::test {

/// The style of a layer in the scene, which has it from then on whatever its view says; as it was, or as the
/// view says it in a plot of which nothing is known.
inline ParticlesStyle& particlesIn(render::Scene& scene, std::size_t layer = 0) {
    auto& style = scene.layers[layer].particles;
    if (!style) style = particlesStyleOf(*scene.view.layers[layer].particles());
    return *style;
}

}  // namespace mote::test
