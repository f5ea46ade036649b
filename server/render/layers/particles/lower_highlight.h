// SPDX-License-Identifier: GPL-3.0-or-later
//
// Highlighted points of a layer become fragments: all of a pixel's stand at one depth and have one colour, so
// they are one (docs/PICTURE.md, "Highlights"). A pure function; uses all threads of the calling arena.
#pragma once

#include "protocol/scene/bounds.h"
#include "protocol/scene/view.h"
#include "server/render/layers/lowering.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

/// `points`: all of its points are drawn, a share of them in motion. `inEye`: the layer's box.
void lowerHighlight(const Layer& layer, const Highlight& highlight, const ParticlesStyle& style,
                    const storage::ParticleStep& points, const Bounds& inEye, Lowering& out);

}  // namespace mote::render
