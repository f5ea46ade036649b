// SPDX-License-Identifier: GPL-3.0-or-later
//
// Points that are so few that each is drawn where it stands, as a dot is: in exact order with volumes, dots
// and the points of other layers, not mixed within a slab (docs/PICTURE.md). Pure functions.
#pragma once

#include "server/render/cpu/disc_footprint.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/screen_dots.h"

namespace mote::render {

/// Whether each point of a layer is drawn where it stands. The same on all ranks, before points are dealt.
bool standAlone(const FramePlan& plan, const PointsPlan& points);

/// What a point of a look covers of a pixel. Its reach is 0 where it lies in one pixel alone.
DotFootprint pointFootprint(const PointLook& look);

}  // namespace mote::render
