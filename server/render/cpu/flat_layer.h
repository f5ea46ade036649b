// SPDX-License-Identifier: GPL-3.0-or-later
//
// Whether depth matters in a picture. A pure function.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "server/render/cpu/composite_frame.h"
#include "server/render/plan/frame_plan.h"

namespace mote::render {

/// The only layer that draws anything, where that is points: depth does not matter then. `volumes`: one a
/// layer.
std::optional<std::uint32_t> flatLayer(const FramePlan& plan, const std::vector<VisibleVolume>& volumes);

}  // namespace mote::render
