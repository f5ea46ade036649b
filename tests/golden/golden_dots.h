// SPDX-License-Identifier: GPL-3.0-or-later
//
// Dots for golden scenes: on a sphere around the beam, on a plane through it, without a depth. Pure
// functions.
#pragma once

#include <memory>

#include "protocol/scene/view.h"
#include "server/render/plan/dot.h"

namespace mote::test {

using DotsOf = std::shared_ptr<const render::Dots> (*)(const View&);

/// Opaque dots of one size, evenly on a sphere: some in front of the beam, some behind it.
std::shared_ptr<const render::Dots> dotsAround(const View& view);

/// Many dots, of all sizes, opacities and colours, on a tilted plane through the beam's core.
std::shared_ptr<const render::Dots> dotsThrough(const View& view);

/// Dots on a spiral around the middle of the picture: in front of all, behind all, and a few at one depth.
std::shared_ptr<const render::Dots> dotsWithoutDepth(const View& view);

}  // namespace mote::test
