// SPDX-License-Identifier: GPL-3.0-or-later
//
// Scene: a valid view together with the data of its layers: all that a picture depends on. A value that
// shares its immutable steps; may be handed to any thread.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "protocol/scene/particles_style.h"
#include "protocol/scene/view.h"
#include "server/render/ink/ink_memory.h"
#include "server/render/layers/mesh/mesh_surface.h"
#include "server/render/layers/particles/point_paths.h"
#include "server/render/plan/dot.h"
#include "server/render/plan/grid_field.h"
#include "server/render/plan/point_values.h"
#include "server/render/plan/point_ways.h"
#include "storage/image/image_file.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

struct Scene {
    View view;
    std::vector<std::shared_ptr<const storage::ParticleStep>>
        steps;                              ///< one a layer; null if it has no particles
    std::shared_ptr<const Dots> dots = {};  ///< of all stipple layers, in pixels of the view; null: none
    /// One a layer, null if it is of another kind; or empty if all are.
    std::vector<std::shared_ptr<const GridField>> hybrids = {};
    std::vector<std::shared_ptr<const MeshSurface>> meshes = {};          ///< likewise
    std::vector<std::shared_ptr<const storage::ColorImage>> images = {};  ///< likewise
    /// Likewise: how particles are drawn, with what their plots say; where it is not known here, as in a plot
    /// of which nothing is known (particlesStyleOf).
    std::vector<std::optional<ParticlesStyle>> particles = {};
    /// Likewise: particles that are drawn as a field of their density (layers/ink/density_grid.h).
    std::vector<std::shared_ptr<const GridField>> densities = {};
    /// Likewise, of layers of particles: which points are highlighted; by what points are coloured, one value
    /// each of its step's points; the ways of some through all steps.
    std::vector<std::shared_ptr<const storage::ParticleStep>> highlights = {};
    std::vector<std::shared_ptr<const PointValues>> values = {};
    std::vector<std::shared_ptr<const PointPaths>> paths = {};
    /// Likewise: where its points, or those of which the step's are chosen, go to Layer::towards.
    std::vector<std::shared_ptr<const PointWays>> ways = {};
    /// Likewise, of coherent drawings: what is remembered of the one before, and then of this one. Of one
    /// thread at a time.
    std::vector<std::shared_ptr<InkMemory>> inks = {};
};

}  // namespace mote::render
