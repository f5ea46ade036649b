// SPDX-License-Identifier: GPL-3.0-or-later
//
// Light: what lights a surface or the gradient of a volume. A value; a parsed one is valid.
#pragma once

#include <glm/vec3.hpp>

#include "protocol/mote.pb.h"

namespace mote {

/// A light at infinity: its parts add up to a brightness, held within [0, 1].
struct Light {
    glm::dvec3 direction{-0.4, 0.6, 0.7};  ///< towards the light; a parsed one is unit
    bool fixed = false;                    ///< direction in world space; otherwise in eye space
    double ambient = 0.15;
    double diffuse = 0.85;
    double specular = 0.0;
    bool shadow = false;  ///< the surface casts shadows on itself

    bool operator==(const Light&) const = default;
};

/// Of a resolved message (fields/resolve.h).
Light lightOf(const proto::Light& message);

}  // namespace mote
