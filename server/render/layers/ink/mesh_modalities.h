// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a mesh looks like, as a drawing of it is made from: rays through four places of each pixel. Pure; many
// threads work at it.
#pragma once

#include <stop_token>

#include "protocol/scene/ink_style.h"
#include "server/render/ink/modalities.h"
#include "server/render/layers/mesh/mesh_surface.h"
#include "server/render/plan/frame_plan.h"

namespace mote::render {

/// In the size of the plan, whose camera is told; one place a pixel where it is not exact. Grey is the mean
/// over a pixel, `paper` where nothing is seen; depth, angle and part are of its nearest place.
Modalities modalitiesOf(const MeshSurface& surface, const glm::dmat4& transform, const InkStyle& style,
                        const FramePlan& plan, const std::stop_token& stop);

}  // namespace mote::render
