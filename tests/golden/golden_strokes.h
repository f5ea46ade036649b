// SPDX-License-Identifier: GPL-3.0-or-later
//
// Strokes for pictures of golden scenes: pens of all widths and hatched areas, in front of what is there,
// within it and behind it. Pure functions.
#pragma once

#include <memory>

#include "server/render/plan/frame_plan.h"

namespace mote::test {

/// For a plan's picture, from before its nearest depth to behind its farthest; of each seed others.
std::shared_ptr<const render::Strokes> strokesFor(const render::FramePlan& plan, std::uint64_t seed);

/// Gives a plan strokes that lie between two depths.
void addStrokes(render::FramePlan& plan, std::shared_ptr<const render::Strokes> strokes, double nearDepth,
                double farDepth);

}  // namespace mote::test
