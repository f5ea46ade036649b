// SPDX-License-Identifier: GPL-3.0-or-later
//
// Rims: beside a surface in a field rays graze it, so that its border is some pixels wide. A pen draws it as
// one line, and hatches nothing beyond. Pure; one thread.
#pragma once

#include "server/render/ink/raster.h"

namespace mote::render {

/// The opacity from which on a ray sees a surface.
inline constexpr float surfaceOpacity = 0.5F;

/// 1 for each pixel that lies beside a surface and in which the opacity has fallen from surfaceOpacity as
/// steeply as it does at a surface's border; 0 for others, and so where matter thins out gently.
Raster<std::uint8_t> rimsOf(const Raster<float>& opacity);

}  // namespace mote::render
