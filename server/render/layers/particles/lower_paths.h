// SPDX-License-Identifier: GPL-3.0-or-later
//
// The ways of particles through a run become strokes (docs/PICTURE.md, "Paths"). Pure functions.
#pragma once

#include "protocol/scene/view.h"
#include "server/render/layers/lowering.h"
#include "server/render/layers/particles/point_paths.h"
#include "server/render/plan/stroke.h"

namespace mote::render {

/// In pixels of a plan, of which so many are a pixel of the view: what lies nearer than is seen is cut off.
Strokes pathStrokes(const Layer& layer, const Paths& style, const glm::dvec3& pointColor,
                    const PointPaths& paths, const FramePlan& plan, double pixels);

/// The same lines, a pixel of a picture of 720 lines wider on both sides, in the plan's background: what a
/// path passes ends beside it.
Strokes pathCasing(Strokes paths, const FramePlan& plan);

void lowerPaths(const Layer& layer, const Paths& style, const glm::dvec3& pointColor, const PointPaths& paths,
                Lowering& out);

}  // namespace mote::render
