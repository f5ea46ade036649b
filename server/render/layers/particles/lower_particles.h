// SPDX-License-Identifier: GPL-3.0-or-later
//
// A layer of particles becomes points and a field of their density. A pure function of what it is given.
#pragma once

#include <memory>

#include "protocol/scene/view.h"
#include "server/render/layers/lowering.h"

namespace mote::render {

/// `index`: of the layer in its view. Throws storage::StorageError where the octree's bytes are damaged.
void lowerParticles(const Layer& layer, std::size_t index, const ParticlesStyle& style,
                    const std::shared_ptr<const storage::ParticleStep>& step, Lowering& out);

}  // namespace mote::render
