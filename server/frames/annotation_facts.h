// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a frame says beside what it shows, from its scene and its plan. Used by the thread that renders.
#pragma once

#include <memory>

#include "server/data/step_source.h"
#include "server/figures/marks.h"
#include "server/render/layers/scene.h"
#include "server/render/plan/frame_plan.h"

namespace mote::server {

/// In pixels of the scene's view; null where it asks for none.
std::shared_ptr<const Marks> annotationsOf(const render::Scene& scene, const render::FramePlan& plan,
                                           StepSource& data);

}  // namespace mote::server
