// SPDX-License-Identifier: GPL-3.0-or-later
//
// The plan of a picture: the layers of a scene lowered to primitives, and the depths at which something can
// be seen cut into slabs. No device is involved. Pure functions, but for the selections that they share.
#pragma once

#include <stop_token>

#include "server/render/layers/scene.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/quality.h"
#include "server/render/plan/selection_cache.h"

namespace mote::render {

/// Where `stop` is requested meanwhile, the plan may lack something; an exact one that waits lacks surfaces.
/// Throws storage::StorageError where the octree's bytes are damaged.
FramePlan makeFramePlan(const Scene& scene, const Quality& quality, SelectionCache& selections,
                        DeviceAbilities device, Reading reading = Reading::all,
                        const std::stop_token& stop = {});
FramePlan makeFramePlan(const Scene& scene, const Quality& quality);

}  // namespace mote::render
