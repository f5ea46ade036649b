// SPDX-License-Identifier: GPL-3.0-or-later
//
// The reference of views between steps (docs/PICTURE.md, "Between steps"): the mean over evenly spaced places
// of what is shown at each, word by word. Exact where shares are multiples of a 1000th. A pure function.
#pragma once

#include <functional>

#include "protocol/scene/view.h"
#include "tests/reference/reference_renderer.h"

namespace mote::reference {

/// The scene of a view that shows one step of each layer.
using SceneOf = std::function<render::Scene(const View& view)>;

/// Where a point is drawn that its layer's step has at `place`, on the way to Layer::towards; layer space.
using MovedPlace =
    std::function<glm::dvec3(const Layer& layer, std::uint64_t point, const glm::dvec3& place)>;

/// `moved`: empty where nothing moves.
Picture renderBetween(const View& view, const SceneOf& sceneOf, const MovedPlace& moved = {});

}  // namespace mote::reference
