// SPDX-License-Identifier: GPL-3.0-or-later
//
// A layer of particles becomes points and a field of their density; what is highlighted of it, fragments; the
// ways of some, strokes. A pure function of what it is given.
#pragma once

#include "protocol/scene/bounds.h"
#include "protocol/scene/particles_style.h"
#include "protocol/scene/view.h"
#include "server/render/layers/lowering.h"
#include "server/render/layers/particles/point_paths.h"
#include "server/render/layers/scene.h"
#include "server/render/plan/stroke.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

/// Makes the ways of particles through a run strokes (docs/PICTURE.md, "Paths"), in pixels of a plan, of
/// which so many are a pixel of the view: what lies nearer than is seen is cut off.
Strokes pathStrokes(const Layer& layer, const proto::Paths& style, const glm::dvec3& pointColor,
                    const PointPaths& paths, const FramePlan& plan, double pixels);

/// The same lines, a pixel of a picture of 720 lines wider on both sides, in the plan's background: what a
/// path passes ends beside it.
Strokes pathCasing(Strokes paths, const FramePlan& plan);

void lowerPaths(const Layer& layer, const proto::Paths& style, const glm::dvec3& pointColor,
                const PointPaths& paths, Lowering& out);

/// Makes highlighted points fragments: all of a pixel's stand at one depth and have one colour, so they are
/// one (docs/PICTURE.md, "Highlights"). Uses all threads of the calling arena. `points`: all of its points
/// are drawn, a share of them in motion. `inEye`: the layer's box.
void lowerHighlight(const Layer& layer, const Highlight& highlight, const ParticlesStyle& style,
                    const storage::ParticleStep& points, const Bounds& inEye, Lowering& out);

/// How a layer of particles is drawn; `index`: of the layer in the scene's view, here and below.
ParticlesStyle particlesStyleOf(const Scene& scene, std::size_t index);

/// Throws storage::StorageError if the octree's bytes are damaged.
void lowerParticles(const Scene& scene, std::size_t index, Lowering& out);

}  // namespace mote::render
