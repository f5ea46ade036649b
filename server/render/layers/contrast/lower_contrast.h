// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is done for a view's depth contrast (docs/PICTURE.md, "Depth contrast"): rays find which layer is
// nearest in each pixel near two of them, and what is drawn there are fragments among those of all surfaces,
// so that no device knows of it. Pure; works in parallel.
#pragma once

#include <memory>
#include <stop_token>

#include "server/render/layers/contrast/depth_order.h"
#include "server/render/layers/scene.h"
#include "server/render/plan/frame_plan.h"

namespace mote::render {

/// Layers that take part: hybrid volumes, particles (by their volume) and meshes that are no wires, of which
/// something is there.
bool hasDepth(const Layer& layer);

/// Whether a view has it: it is asked for, and two layers at least take part.
bool contrastsDepth(const View& view);

/// Of a scene whose layers are lowered to `plan`; null where nothing is ambiguous. If `stop` is requested
/// meanwhile, something is missing.
std::shared_ptr<const FragmentMaker> depthContrastOf(const Scene& scene, const FramePlan& plan,
                                                     const std::stop_token& stop);

}  // namespace mote::render
