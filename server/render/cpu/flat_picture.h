// SPDX-License-Identifier: GPL-3.0-or-later
//
// The picture of points where depth does not matter: n points of opacity a leave (1 - a)^n of the background.
// Pure functions; they use all threads of the calling arena.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "server/render/cpu/flat_points.h"
#include "server/render/cpu/resident_fields.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/picture.h"

namespace mote::render {

/// Which points are the only thing that is drawn, where points of one look are: depth does not matter then.
/// `fields`: one of the plan's each.
std::optional<std::uint32_t> flatPoints(const FramePlan& plan, const std::vector<VisibleField>& fields);

Picture flatPicture(const FramePlan& plan, const PointsPlan& only, const FlatPoints& points,
                    PixelFormat format);

}  // namespace mote::render
