// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/light.h"

#include <glm/geometric.hpp>

#include "protocol/scene/check.h"

namespace mote {

Result<Light> parseLight(const proto::Light& message, const Light& fallback) {
    Light light = fallback;
    glm::dvec3 direction = fallback.direction;
    if (!message.direction().empty()) {
        MOTE_ASSIGN_OR_RETURN(direction, checkVector(message.direction(), 1e6, "direction"));
    }
    if (!(glm::length(direction) > 1e-6)) {
        return Error{ErrorCode::invalidArgument, "direction", "a direction must not be zero"};
    }
    light.direction = glm::normalize(direction);
    light.fixed = message.fixed();
    light.shadow = message.shadow();
    MOTE_ASSIGN_OR_RETURN(
        light.ambient,
        checkRange(message.has_ambient() ? message.ambient() : fallback.ambient, 0.0, 1.0, "ambient"));
    MOTE_ASSIGN_OR_RETURN(
        light.diffuse,
        checkRange(message.has_diffuse() ? message.diffuse() : fallback.diffuse, 0.0, 1.0, "diffuse"));
    MOTE_ASSIGN_OR_RETURN(
        light.specular,
        checkRange(message.has_specular() ? message.specular() : fallback.specular, 0.0, 1.0, "specular"));
    return light;
}

}  // namespace mote
