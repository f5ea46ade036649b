// SPDX-License-Identifier: GPL-3.0-or-later
//
// MovedPoints: the points of a step that are drawn, on their way to another step of their run
// (docs/PICTURE.md, "Between steps"), or those of them that clips leave ("Clipping"). A value; the functions
// are pure and use all threads of the calling arena.
#pragma once

#include <memory>

#include "protocol/scene/clip.h"
#include "server/render/plan/point_selection.h"
#include "server/render/plan/point_values.h"
#include "server/render/plan/point_ways.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

struct MovedPoints {
    /// Only they. It is what devices draw, and no more: no octree, its nodes being the cells of its leaves,
    /// which may lie in each other; without densities.
    std::shared_ptr<const storage::ParticleStep> step;
    std::shared_ptr<const PointSelection>
        selection;                              ///< all of them, weighing what they did, with their levels
    std::shared_ptr<const PointValues> values;  ///< null: they had none
};

/// `step`: the one that the ways begin at, or points chosen of it. `selection`: null: all points. `values`:
/// of the step's points, or null. A place is told to 2^-16 of its leaf's cell, which is no larger than 2^-8
/// of the box. Throws storage::StorageError.
MovedPoints movePoints(const storage::ParticleStep& step, const PointSelection* selection,
                       const PointWays& ways, double share, const PointValues* values);

/// Those in all half-spaces of layer space, each in its place; of whole leaves none where nothing stays of
/// their cells. The rest as above.
MovedPoints cutPoints(const storage::ParticleStep& step, const PointSelection* selection,
                      const HalfSpaces& clips, const PointValues* values);

}  // namespace mote::render
