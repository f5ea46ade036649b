// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/frame_plan.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

namespace mote::render {

double nearLimit(const Camera& camera) {
    return camera.perspective() ? nearShare * glm::length(camera.target - camera.eye)
                                : -std::numeric_limits<double>::infinity();
}

glm::dmat4 plotToLayer() {
    return glm::scale(glm::translate(glm::dmat4(1.0), glm::dvec3(-1.0)), glm::dvec3(2.0));
}

}  // namespace mote::render
