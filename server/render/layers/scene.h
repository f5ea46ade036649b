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

/// What a layer is drawn from, beside its settings in the view. Null is what these do not ask for; all of it,
/// where there is nothing of the layer.
struct LayerData {
    std::shared_ptr<const storage::ParticleStep> step = {};  ///< of a layer of particles: those to be shown
    /// How these are drawn, with what their plots say; where it is not known here, as in a plot of which
    /// nothing is known (particlesStyleOf).
    std::optional<ParticlesStyle> particles = {};
    std::shared_ptr<const storage::ParticleStep> highlight = {};  ///< which of these are highlighted
    std::shared_ptr<const PointValues> values = {};  ///< by what they are coloured, one value each of `step`
    std::shared_ptr<const PointPaths> paths = {};    ///< the ways of some through all steps
    /// Where they, or those of which they are chosen, go to Layer::towards.
    std::shared_ptr<const PointWays> ways = {};
    std::shared_ptr<const GridField> hybrid = {};
    std::shared_ptr<const MeshSurface> mesh = {};
    std::shared_ptr<const storage::ColorImage> image = {};
    /// Of ink of particles: the field of their density (layers/ink/density_grid.h).
    std::shared_ptr<const GridField> density = {};
    /// Of a coherent drawing: what is remembered of the one before, and then of this one. Of one thread at a
    /// time.
    std::shared_ptr<InkMemory> ink = {};
};

struct Scene {
    View view;
    std::vector<LayerData> layers = {};     ///< one a layer of the view
    std::shared_ptr<const Dots> dots = {};  ///< of all stipple layers, in pixels of the view; null: none
};

}  // namespace mote::render
