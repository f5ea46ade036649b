// SPDX-License-Identifier: GPL-3.0-or-later
//
// What sliders hold of a message's numbers, and back: floats, and directions as two angles. Pure functions.
#pragma once

#include <array>
#include <glm/vec3.hpp>

#include "protocol/mote.pb.h"

namespace mote::client {

struct LightAngles {
    float across = 0.0F;  ///< degrees to the right of the z axis, which points to the eye
    float above = 0.0F;   ///< degrees above it

    /// The angles of a vector that is not zero.
    static LightAngles of(const glm::dvec3& direction);
    glm::dvec3 direction() const;  ///< unit

    bool operator==(const LightAngles&) const = default;
};

std::array<float, 3> toFloats(const glm::dvec3& vector);
glm::dvec3 toVector(const std::array<float, 3>& numbers);

/// The number that a slider shows: 0.1 is 0.1, not the 0.10000000149 that a float makes of it.
double decimal(float value);
/// Holds a value within [0, 1]: sliders may be a rounding error outside.
double share(float value);

/// A colour as a message says it, sRGB-encoded; one that it leaves out as it is drawn, linear RGB.
std::array<float, 3> shownColor(const google::protobuf::RepeatedField<double>& said, const glm::dvec3& drawn);

/// Replaces the three numbers of a vector.
void assign(google::protobuf::RepeatedField<double>* field, const glm::dvec3& vector);
/// The same of a colour, each number a share.
void assignColor(google::protobuf::RepeatedField<double>* field, const std::array<float, 3>& color);

}  // namespace mote::client
