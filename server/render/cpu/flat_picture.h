// SPDX-License-Identifier: GPL-3.0-or-later
//
// The picture of points where depth does not matter: n points of opacity a leave (1 - a)^n of the background.
// A pure function; it uses all threads of the calling arena.
#pragma once

#include "server/render/cpu/flat_points.h"
#include "server/render/picture.h"
#include "server/render/plan/frame_plan.h"

namespace mote::render {

Picture flatPicture(const FramePlan& plan, const LayerPlan& layer, const FlatPoints& points,
                    PixelFormat format);

}  // namespace mote::render
