// SPDX-License-Identifier: GPL-3.0-or-later
//
// Strokes become fragments (docs/PICTURE.md, "Strokes"): what lines and areas cover of each pixel, and at
// what depth. A pure function, shared by all devices.
#pragma once

#include <cstdint>
#include <vector>

#include "server/render/plan/fragment.h"
#include "server/render/plan/stroke.h"

namespace mote::render {

/// Those in a picture of so many pixels that lie no nearer than a depth, in parts, whose order counts as that
/// of fragments does. In turns (in_turns.h), on all threads of the calling arena; the same fragments on any
/// number of them. Throws
/// std::bad_alloc, also where there would be more fragments than fit.
std::vector<Fragments> strokeFragments(const Strokes& strokes, std::uint32_t width, std::uint32_t height,
                                       double nearDepth);

}  // namespace mote::render
