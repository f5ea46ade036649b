// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a session's pictures tell of the next one: how much there is to draw, and how long it takes. Functions
// of the thread that renders.
#pragma once

#include "server/frames/picture_history.h"
#include "server/frames/quality_controller.h"
#include "server/render/layers/scene.h"
#include "server/render/plan/picture.h"
#include "server/render/plan/quality.h"

namespace mote::server {

/// How many points an exact picture draws depends on the view, and the latest picture of the same data tells
/// it best: views of one hand follow each other closely. It is taken with care (a view that saw nothing is
/// followed by one that does), and of new data all points are expected.
ViewLoad loadOf(const render::Scene& scene, const PictureHistory& history);

/// `share`: of the exact picture's points. `ms`: that it took, apart from data.
void learn(PictureHistory& history, const render::Scene& scene, const render::Picture& picture,
           const render::Quality& quality, double share, double ms);

}  // namespace mote::server
