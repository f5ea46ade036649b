// SPDX-License-Identifier: GPL-3.0-or-later
//
// The golden scenes of hybrid volumes, part of golden_scenes.h. Pure functions.
#pragma once

#include <string>

#include "server/render/layers/scene.h"

namespace mote::test {

/// Throws std::invalid_argument where there is none of this name.
render::Scene makeHybridScene(const std::string& name);

}  // namespace mote::test
