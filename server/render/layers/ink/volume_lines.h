// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lines of what has no edges: where a scalar field ends for the eye, or lies in front of something else
// (docs/INK.md, "Volumes and particles"). Pure; works in parallel.
#pragma once

#include <stop_token>
#include <vector>

#include "server/render/ink/ink_line.h"
#include "server/render/ink/raster.h"
#include "server/render/layers/ink/volume_modalities.h"

namespace mote::render {

/// The opacity from which on a ray sees a surface.
inline constexpr float surfaceOpacity = 0.5F;

/// Returns the rims: beside a surface in a field rays graze it, so that its border is some pixels wide. A pen
/// draws it as one line, and hatches nothing beyond. 1 for each pixel that lies beside a surface and in which
/// the opacity has fallen from surfaceOpacity as steeply as it does at a surface's border; 0 for others, and
/// so where matter thins out gently.
Raster<std::uint8_t> rimsOf(const Raster<float>& opacity);

/// Silhouettes, between rays that are told apart by their opacities or depths. In the order of rows.
std::vector<InkLine> linesOf(const VolumeModalities& seen, const std::stop_token& stop);

}  // namespace mote::render
