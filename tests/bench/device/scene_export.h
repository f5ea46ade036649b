// SPDX-License-Identifier: GPL-3.0-or-later
//
// Writes a bench scene for another program to draw: "scene.json" (size, camera, eyes, transfer functions),
// and what it shows: "points.f32" (x, y, z of every point in layer space) or "volume.u8" (255 t, x fastest).
// A pure function, but for the files.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <vector>

#include "protocol/base/error.h"
#include "server/render/layers/scene.h"

namespace mote::bench {

/// `folder` exists. Errors: internal, a file that cannot be written.
Status exportScene(const render::Scene& scene, const std::vector<glm::dvec3>& eyes,
                   const std::filesystem::path& folder);

}  // namespace mote::bench
