// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which camera sees all that a view shows, once the boxes of its datasets are known. Pure functions.
#pragma once

#include <optional>
#include <span>

#include "protocol/scene/bounds.h"
#include "protocol/scene/view.h"

namespace mote {

/// Whether a camera shows more or less of a layer: not of one that lies on the picture itself, or of which
/// there is nothing.
bool isFitted(const Layer& layer);

/// Fits the camera of a view that came without one to its layers; another's stays as it is. `boxes`: of each
/// layer's dataset, layer space; nothing where there is none to be seen. Annotated axes get room for labels.
void fitLayers(View& view, std::span<const std::optional<Bounds>> boxes);

}  // namespace mote
