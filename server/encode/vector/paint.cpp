// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/paint.h"

#include <algorithm>
#include <glm/common.hpp>

#include "protocol/scene/srgb.h"

namespace mote::server {

glm::vec3 encoded(const glm::vec3& linear) {
    return glm::vec3(linearToSrgb(glm::clamp(glm::dvec3(linear), 0.0, 1.0)));
}

Paint paintOver(const glm::vec3& color, double opacity, const glm::vec3& beneath, double least) {
    if (opacity >= 1.0 || !(opacity > 0.0)) return {encoded(color), std::clamp(opacity, 0.0, 1.0)};
    const auto share = static_cast<float>(opacity);
    const glm::vec3 under = encoded(beneath);
    const glm::vec3 wanted = encoded(share * color + (1.0F - share) * beneath);
    double needed = std::max(opacity, least);
    for (int i = 0; i < 3; ++i) {
        const double step = wanted[i] - under[i];
        const double most = step > 0.0 ? 1.0 - under[i] : under[i];
        if (most > 0.0) needed = std::max(needed, std::abs(step) / most);
    }
    needed = std::min(needed, 1.0);
    const auto part = static_cast<float>(needed);
    return {glm::clamp((wanted - (1.0F - part) * under) / part, glm::vec3(0.0F), glm::vec3(1.0F)), needed};
}

}  // namespace mote::server
