// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/bounds.h"

#include <glm/common.hpp>

namespace mote {

std::array<glm::dvec3, 8> Bounds::corners() const {
    std::array<glm::dvec3, 8> result;
    for (unsigned i = 0; i < 8; ++i) {
        result[i] = {i & 1U ? max.x : min.x, i & 2U ? max.y : min.y, i & 4U ? max.z : min.z};
    }
    return result;
}

Bounds Bounds::united(const Bounds& other) const {
    return {glm::min(min, other.min), glm::max(max, other.max)};
}

Bounds Bounds::transformed(const glm::dmat4& transform) const {
    const auto at = [&](const glm::dvec3& point) { return glm::dvec3(transform * glm::dvec4(point, 1.0)); };
    const auto points = corners();
    Bounds result{at(points[0]), at(points[0])};
    for (const auto& point : points) {
        result = result.united({at(point), at(point)});
    }
    return result;
}

}  // namespace mote
