// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a mesh looks like, as a drawing of it is made from: rays through four places of each pixel. Pure; many
// threads work at it.
#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <stop_token>

#include "protocol/scene/ink_style.h"
#include "server/render/ink/modalities.h"
#include "server/render/layers/mesh/mesh_surface.h"
#include "server/render/plan/frame_plan.h"

namespace mote::render {

struct MeshModalities {
    Modalities modalities;
    /// The triangle that is seen in each pixel, or MeshMeeting::none.
    Raster<std::uint32_t> triangle;
    /// The greatest depth that is seen in each pixel; infinity if nothing is in a part of it.
    Raster<float> farthest;
};

/// In the size of the plan, whose camera is told; one place a pixel if it is not exact, or
/// the style asks for no tones. Grey is the mean
/// over a pixel, `paper` where nothing is seen; depth, angle, part and triangle are of its
/// nearest place.
MeshModalities modalitiesOf(const MeshSurface& surface, const glm::dmat4& transform, const InkStyle& style,
                            const FramePlan& plan, const std::stop_token& stop);

/// Of the surface that is seen at a place of the plan's picture, in pixels from its upper left corner, the
/// depth; nothing where none is.
std::optional<double> depthAt(const MeshSurface& surface, const glm::dmat4& transform, const InkStyle& style,
                              const FramePlan& plan, glm::dvec2 at);

}  // namespace mote::render
