// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/camera.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/trigonometric.hpp>

#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/write_fields.h"

namespace mote {

glm::dmat4 Camera::worldToEye() const {
    return glm::lookAt(eye, target, up);
}

double Camera::halfHeight() const {
    return orthographicHeight ? 0.5 * *orthographicHeight : std::tan(glm::radians(0.5 * fovYDegrees));
}

Camera fitCamera(const Bounds& bounds, double aspect) {
    constexpr double margin = 1.03;  // of the distance at which the box would touch the picture's border
    Camera camera;
    camera.target = bounds.center();
    const glm::dvec3 back = glm::normalize(glm::dvec3(0.55, 0.4, 1.0));
    const glm::dvec3 right = glm::normalize(glm::cross(camera.up, back));
    const glm::dvec3 above = glm::cross(back, right);
    const double halfY = camera.halfHeight();
    const double halfX = halfY * aspect;
    // A corner (x, y) off the axis and z nearer than the target is seen from any distance d with
    // |x| <= halfX (d - z) and |y| <= halfY (d - z).
    double distance = 0.0;
    for (const auto& corner : bounds.corners()) {
        const glm::dvec3 offset = corner - camera.target;
        const double sideways =
            std::max(std::abs(glm::dot(offset, right)) / halfX, std::abs(glm::dot(offset, above)) / halfY);
        distance = std::max(distance, margin * sideways + glm::dot(offset, back));
    }
    // A box that is a point is looked at from as near as its place can still be told from the eye's.
    distance = std::max(distance, 1e-6 * (1.0 + glm::length(camera.target)));
    camera.eye = camera.target + distance * back;
    return camera;
}

Result<Camera> parseCamera(const proto::Camera& said) {
    MOTE_ASSIGN_OR_RETURN(const auto message, resolved(said));
    Camera camera{.eye = readVector(message.eye()),
                  .target = readVector(message.target()),
                  .up = readVector(message.up()),
                  .fovYDegrees = message.fov_y_degrees(),
                  .orthographicHeight = std::nullopt};
    if (message.has_orthographic_height()) camera.orthographicHeight = message.orthographic_height();
    const glm::dvec3 sight = camera.target - camera.eye;
    if (!(glm::length(sight) > 1e-9 * (1.0 + glm::length(camera.eye)))) {
        return invalid("target", "the target must differ from the eye");
    }
    const double sine = glm::length(glm::cross(glm::normalize(sight), camera.up)) / glm::length(camera.up);
    if (!(sine > 1e-6)) {
        return invalid("up", "up must be a direction away from the line of sight");
    }
    return camera;
}

proto::Camera toProto(const Camera& camera) {
    proto::Camera message;
    writeVector(camera.eye, message.mutable_eye());
    writeVector(camera.target, message.mutable_target());
    writeVector(camera.up, message.mutable_up());
    message.set_fov_y_degrees(camera.fovYDegrees);
    if (camera.orthographicHeight) message.set_orthographic_height(*camera.orthographicHeight);
    return message;
}

}  // namespace mote
