// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which places in the world the files of meshes and stipples may hold. A pure function.
#pragma once

#include <cmath>
#include <glm/vec3.hpp>

namespace mote::storage {

/// Of each coordinate, in world units. Squares of distances between such places are floats, so that rays can
/// begin at them; a light year has 1e16 metres.
inline constexpr float mostCoordinate = 1e18F;

inline bool isPlace(const glm::vec3& at) {
    const auto within = [](float c) { return std::abs(c) <= mostCoordinate; };  // no NaN, either
    return within(at.x) && within(at.y) && within(at.z);
}

}  // namespace mote::storage
