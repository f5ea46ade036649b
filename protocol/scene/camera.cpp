// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/camera.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/trigonometric.hpp>

#include "protocol/scene/check.h"

namespace mote {
namespace {

constexpr double worldLimit = 1e12;  // far from overflow when squared and transformed in double precision

void assign(google::protobuf::RepeatedField<double>* field, const glm::dvec3& vector) {
    field->Assign(&vector.x, &vector.x + 3);
}

}  // namespace

glm::dmat4 Camera::worldToEye() const {
    return glm::lookAt(eye, target, up);
}

double Camera::halfHeight() const {
    return orthographicHeight ? 0.5 * *orthographicHeight : std::tan(glm::radians(0.5 * fovYDegrees));
}

Camera fitCamera(const Bounds& bounds, double aspect) {
    Camera camera;
    const double radius = std::max(0.5 * glm::length(bounds.size()), 1e-9);
    const double halfAngleY = glm::radians(0.5 * camera.fovYDegrees);
    const double halfAngleX = std::atan(std::tan(halfAngleY) * aspect);
    // A little closer than the bounding sphere asks for: the corners of the box are seldom filled.
    const double distance = 0.9 * radius / std::sin(std::min(halfAngleX, halfAngleY));
    camera.target = bounds.center();
    camera.eye = camera.target + distance * glm::normalize(glm::dvec3(0.55, 0.4, 1.0));
    return camera;
}

Result<Camera> parseCamera(const proto::Camera& message) {
    Camera camera;
    const auto eye = checkVector(message.eye(), worldLimit, "eye");
    MOTE_RETURN_IF_ERROR(eye);
    const auto target = checkVector(message.target(), worldLimit, "target");
    MOTE_RETURN_IF_ERROR(target);
    camera.eye = *eye;
    camera.target = *target;
    if (!message.up().empty()) {
        const auto up = checkVector(message.up(), worldLimit, "up");
        MOTE_RETURN_IF_ERROR(up);
        camera.up = *up;
    }
    const glm::dvec3 sight = camera.target - camera.eye;
    if (!(glm::length(sight) > 1e-9 * (1.0 + glm::length(camera.eye)))) {
        return Error{ErrorCode::invalidArgument, "target", "the target must differ from the eye"};
    }
    const double sine = glm::length(glm::cross(glm::normalize(sight), camera.up)) / glm::length(camera.up);
    if (!(sine > 1e-6)) {
        return Error{ErrorCode::invalidArgument, "up", "up must be a direction away from the line of sight"};
    }
    if (message.has_fov_y_degrees()) {
        MOTE_RETURN_IF_ERROR(checkRange(message.fov_y_degrees(), 0.1, 170.0, "fovYDegrees"));
        camera.fovYDegrees = message.fov_y_degrees();
    }
    if (message.has_orthographic_height()) {
        MOTE_RETURN_IF_ERROR(
            checkRange(message.orthographic_height(), 1e-9, worldLimit, "orthographicHeight"));
        camera.orthographicHeight = message.orthographic_height();
    }
    return camera;
}

proto::Camera toProto(const Camera& camera) {
    proto::Camera message;
    assign(message.mutable_eye(), camera.eye);
    assign(message.mutable_target(), camera.target);
    assign(message.mutable_up(), camera.up);
    message.set_fov_y_degrees(camera.fovYDegrees);
    if (camera.orthographicHeight) message.set_orthographic_height(*camera.orthographicHeight);
    return message;
}

}  // namespace mote
