// SPDX-License-Identifier: GPL-3.0-or-later
//
// InkData: what an ink layer is a drawing of: a surface, or a scalar field that is seen by a transfer
// function. A value that shares its immutable data.
#pragma once

#include <cstddef>
#include <memory>
#include <variant>

#include "protocol/scene/bounds.h"
#include "protocol/scene/transfer_function.h"
#include "server/render/layers/mesh/mesh_surface.h"
#include "server/render/layers/scene.h"
#include "server/render/plan/grid_field.h"

namespace mote::render {

/// A hybrid volume in the source's unit, or particles as scaled log densities on a grid (density_grid.h).
struct InkVolume {
    std::shared_ptr<const GridField> field;
    TransferFunction transfer;
    HalfSpaces clips = {};  ///< layer space: what lies in all of them is seen
};

using InkData = std::variant<std::shared_ptr<const MeshSurface>, InkVolume>;

/// The data of an ink layer. What its style leaves open is as a "hybrid" or a "particles" layer of the
/// dataset has it.
InkData inkDataOf(const Layer& layer, const LayerData& data);

/// How ink sees a field. `density`: of particles.
TransferFunction inkTransfer(const InkStyle& style, const GridField& field, bool density);

/// Layer space.
Bounds boundsOf(const InkData& data);

}  // namespace mote::render
