// SPDX-License-Identifier: GPL-3.0-or-later
//
// Golden scenes of particles that are coloured by a column, highlighted and followed: see golden_scenes.h.
#pragma once

#include <optional>
#include <string>

#include "server/render/layers/scene.h"

namespace mote::test {

/// Nothing: there is no such scene.
std::optional<render::Scene> makeColoredScene(const std::string& name);

}  // namespace mote::test
