// SPDX-License-Identifier: GPL-3.0-or-later
//
// MeshStyle: the look of a mesh layer, a shaded surface (docs/PICTURE.md, "Meshes"). A value; a parsed one is
// valid.
#pragma once

#include <glm/vec3.hpp>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "protocol/scene/length_scale.h"
#include "protocol/scene/light.h"
#include "protocol/scene/srgb.h"

namespace mote {

struct MeshStyle {
    glm::dvec3 color = srgbToLinear(glm::dvec3(0.8));  ///< linear RGB
    double opacity = 1.0;                              ///< of each surface that a ray meets
    Light light;
    bool wire = false;  ///< the edges of its triangles are drawn in place of their faces
    ScreenLength wireWidth = ScreenLength::usual(1.0);  ///< pixels; no view says another

    bool operator==(const MeshStyle&) const = default;
};

/// Fills every default. Errors: a number out of range.
Result<MeshStyle> parseMeshStyle(const proto::MeshStyle& message);

}  // namespace mote
