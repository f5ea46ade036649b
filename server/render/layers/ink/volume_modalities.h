// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a scalar field looks like, as a drawing of it is made from: averages along rays through up to four
// places of each pixel, without any mesh (docs/INK.md, "Volumes and particles"). Pure; many threads work at
// it.
#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <stop_token>
#include <vector>

#include "protocol/scene/ink_style.h"
#include "server/render/ink/ink_line.h"
#include "server/render/ink/modalities.h"
#include "server/render/layers/ink/ink_data.h"
#include "server/render/plan/frame_plan.h"

namespace mote::render {

/// Of the extent: what lies apart in depth by less is one surface.
inline constexpr double leastDepthStep = 0.005;

struct VolumeModalities {
    Modalities modalities;
    /// Rays a side of a pixel, evenly: 1 or 2.
    std::uint32_t side = 1;
    Raster<float> opacity;  ///< of each ray, `side` times as wide and high as the picture
    Raster<float> depth;    ///< likewise, world units; infinity if the opacity is small
};

/// In the size of the plan, whose camera is told; one ray a pixel if it is not exact, or very large, or
/// if four would see the same. Grey is the mean over a pixel, paper through what is left of a ray; depth
/// is that of its nearest ray, and the angle of the sum of their normals. Nothing is seen if less than 2 %
/// of a ray is absorbed, nor in the rims of surfaces (rimsOf).
/// `lines`: takes what linesOf() finds meanwhile (volume_lines.h); null: nobody asks.
VolumeModalities modalitiesOf(const InkVolume& volume, const glm::dmat4& transform, const InkStyle& style,
                              const FramePlan& plan, const std::stop_token& stop,
                              std::vector<InkLine>* lines = nullptr);

/// As depthAt() of meshes.
std::optional<double> depthAt(const InkVolume& volume, const glm::dmat4& transform, const InkStyle& style,
                              const FramePlan& plan, glm::dvec2 at);

}  // namespace mote::render
