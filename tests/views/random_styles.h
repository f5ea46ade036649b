// SPDX-License-Identifier: GPL-3.0-or-later
//
// Styles of generated views: every field of a layer's style, left out, at its ends and between them. Pure
// functions of the numbers that they draw.
#pragma once

#include "protocol/mote.pb.h"
#include "tests/support/random.h"
#include "tests/views/view_data.h"

namespace mote::test {

proto::ParticlesStyle anyParticlesStyle(Random& random);
proto::HybridStyle anyHybridStyle(Random& random, const DatasetTraits& data);
proto::StippleStyle anyStippleStyle(Random& random);
proto::InkStyle anyInkStyle(Random& random);
/// The same of a volume, or of particles.
proto::InkStyle anyInkStyle(Random& random, const DatasetTraits& data);
proto::MeshStyle anyMeshStyle(Random& random);
/// Planes and boxes that mostly go through `bounds`, now and then none.
proto::Clip anyClip(Random& random, const Bounds& bounds);

}  // namespace mote::test
