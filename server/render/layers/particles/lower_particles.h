// SPDX-License-Identifier: GPL-3.0-or-later
//
// A layer of particles becomes points and a field of their density; what is highlighted of it, fragments; the
// ways of some, strokes. A pure function of what it is given.
#pragma once

#include "protocol/scene/particles_style.h"
#include "server/render/layers/lowering.h"
#include "server/render/layers/scene.h"

namespace mote::render {

/// `index`: of the layer in the scene's view. Throws storage::StorageError where the octree's bytes are
/// damaged.
void lowerParticles(const Scene& scene, std::size_t index, const ParticlesStyle& style, Lowering& out);

}  // namespace mote::render
