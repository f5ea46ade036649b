// SPDX-License-Identifier: GPL-3.0-or-later
//
// LightAngles: a direction as two angles that sliders hold. Pure functions.
#pragma once

#include <glm/vec3.hpp>

#include "protocol/mote.pb.h"

namespace mote::client {

struct LightAngles {
    float across = 0.0F;  ///< degrees to the right of the z axis, which points to the eye
    float above = 0.0F;   ///< degrees above it

    /// Of a vector that is not zero.
    static LightAngles of(const glm::dvec3& direction);
    glm::dvec3 direction() const;  ///< unit

    bool operator==(const LightAngles&) const = default;
};

/// The three numbers of a vector.
void assign(google::protobuf::RepeatedField<double>* field, const glm::dvec3& vector);

}  // namespace mote::client
