// SPDX-License-Identifier: GPL-3.0-or-later
//
// shadesOf() tells what a light makes of each one-byte normal (docs/PICTURE.md, "Light"). A pure function.
#pragma once

#include <glm/mat4x4.hpp>

#include "protocol/scene/light.h"
#include "server/render/plan/field_plan.h"

namespace mote::render {

/// `layerToEye`: takes normals of layer space to eye space; `worldToEye`: a fixed light.
Shades shadesOf(const Light& light, const glm::dmat4& layerToEye, const glm::dmat4& worldToEye);

}  // namespace mote::render
