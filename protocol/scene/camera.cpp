// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/camera.h"

#include <algorithm>
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

namespace {

constexpr double nothingYet = -std::numeric_limits<double>::infinity();
constexpr std::size_t slopes = 4;  // of planes through the eye, as shares of the picture's own
constexpr std::size_t nearest = 4 * slopes;
constexpr int ofPicture = nearest + 2;  // directions that are the picture's
static_assert(CameraFit::directions == ofPicture + 6);
constexpr double leastDistance = 0.05;  // of the eye from the nearest place, as a share of the depth

double slope(std::size_t i) {
    return 1.0 - static_cast<double>(i) / (slopes - 1);
}

}  // namespace

CameraFit::CameraFit(const Outlook& outlook, double aspect, double margin) : up_(outlook.up) {
    const glm::dvec3 back = glm::normalize(outlook.back);
    const glm::dvec3 right = glm::normalize(glm::cross(outlook.up, back));
    axes_ = {right, glm::cross(back, right), back};
    tanY_ = Camera{}.halfHeight() * (1.0 - 2.0 * margin);
    tanX_ = tanY_ * aspect;
    for (std::size_t i = 0; i < slopes; ++i) {
        const glm::dvec3 outX = slope(i) * tanX_ * back, outY = slope(i) * tanY_ * back;
        world_[4 * i] = -right + outX;
        world_[4 * i + 1] = right + outX;
        world_[4 * i + 2] = -axes_[1] + outY;
        world_[4 * i + 3] = axes_[1] + outY;
    }
    world_[nearest] = back;
    world_[nearest + 1] = -back;
    most_.fill(nothingYet);
    enter(glm::dmat4(1.0));
    unit_ = 0.0;
}

void CameraFit::enter(const glm::dmat4& layerToWorld, HalfSpaces clips) {
    clips_ = std::move(clips);
    const glm::dmat3 linear(layerToWorld);
    for (int i = 0; i < 3; ++i) unit_ = std::max(unit_, glm::length(linear[i]));
    for (int i = 0; i < ofPicture; ++i) {
        const auto at = static_cast<std::size_t>(i);
        normals_[at] = world_[at] * linear;
        offsets_[at] = glm::dot(world_[at], glm::dvec3(layerToWorld[3]));
    }
    for (int i = ofPicture; i < directions; ++i) {
        const auto at = static_cast<std::size_t>(i);
        normals_[at] = glm::dvec3(0.0);
        normals_[at][(i - ofPicture) / 2] = i % 2 == 0 ? -1.0 : 1.0;
        most_[at] = nothingYet;
    }
}

void CameraFit::add(const glm::dvec3& place) {
    const double sum = place.x + place.y + place.z;
    if (!std::isfinite(sum)) return;
    for (std::size_t i = 0; i < directions; ++i)
        most_[i] = std::max(most_[i], glm::dot(normals_[i], place) + offsets_[i]);
}

void CameraFit::add(const Bounds& box) {
    for (const auto& corner : box.corners()) add(corner);
}

double CameraFit::reach(int i, const Bounds& box) const {
    const auto at = static_cast<std::size_t>(i);
    const double half = 0.5 * glm::dot(glm::abs(normals_[at]), box.size());
    return glm::dot(normals_[at], box.center()) + half + offsets_[at] - most_[at];
}

double CameraFit::reach(const Bounds& box) const {
    double most = nothingYet;
    for (int i = 0; i < directions; ++i) most = std::max(most, reach(i, box));
    return most;
}

std::optional<Bounds> CameraFit::inLayer() const {
    const auto* const box = &most_[ofPicture];
    if (!(box[0] > nothingYet)) return std::nullopt;
    return Bounds{{-box[0], -box[2], -box[4]}, {box[1], box[3], box[5]}};
}

/// Where an eye at height z has as much room on one side, 0 or 2, as on the other. Between two slopes a plane
/// that touches from outside is at most as far out as their mean: what is found there is exact at the slopes.
double CameraFit::middle(std::size_t side, double tangent, double z) const {
    const auto sums = [&](std::size_t i) { return most_[4 * i + side] + most_[4 * i + side + 1]; };
    const auto room = [&](std::size_t i) { return 2.0 * slope(i) * tangent * z - sums(i); };
    std::size_t inner = 1;
    while (inner + 1 < slopes && room(inner) > 0.0) ++inner;
    const double wide = room(inner - 1), narrow = room(inner);
    const double share = narrow < 0.0 && wide > narrow ? std::clamp(wide / (wide - narrow), 0.0, 1.0) : 1.0;
    const auto at = [&](std::size_t i) { return 0.5 * (most_[4 * i + side + 1] - most_[4 * i + side]); };
    return at(inner - 1) + share * (at(inner) - at(inner - 1));
}

/// With the eye at (x, y, z) of right, above and back, a side's plane holds a place (p, q, r) where
/// |p - x| <= tanX (z - r) and |q - y| <= tanY (z - r): each side asks for one sum of coordinates alone.
Camera CameraFit::camera() const {
    Camera camera;
    if (empty()) return camera;
    const double left = most_[0], right = most_[1], lower = most_[2], upper = most_[3];
    const double near = most_[nearest], far = -most_[nearest + 1];
    const double depth = 0.5 * (near + far);
    // Along what is long and thin all sides may touch the nearest place alone: the eye keeps away from it.
    const double z = std::max({(left + right) / (2.0 * tanX_), (lower + upper) / (2.0 * tanY_),
                               near + leastDistance * (near - far)});
    const glm::dvec3 eye(middle(0, tanX_, z), middle(2, tanY_, z), z);
    // What is a point is looked at from as near as its place can still be told from the eye's.
    const double away = std::max(z - depth, 1e-6 * unit_ + 2.0 * leastSight(eye));
    camera.target = axes_ * glm::dvec3(eye.x, eye.y, depth);
    camera.eye = camera.target + away * axes_[2];
    camera.up = up_;
    return camera;
}

Camera fitCamera(const Bounds& bounds, double aspect, const Outlook& outlook, double margin) {
    const glm::dvec3 back = glm::normalize(outlook.back);
    const glm::dvec3 right = glm::normalize(glm::cross(outlook.up, back));
    const glm::dvec3 above = glm::cross(back, right);
    Camera camera;
    camera.target = bounds.center();
    camera.up = outlook.up;
    const double halfY = camera.halfHeight() * (1.0 - 2.0 * margin);
    const double halfX = halfY * aspect;
    // A corner (x, y) off the axis and z nearer than the target is seen from any distance d with
    // |x| <= halfX (d - z) and |y| <= halfY (d - z).
    double distance = 0.0;
    for (const auto& corner : bounds.corners()) {
        const glm::dvec3 offset = corner - camera.target;
        const double sideways =
            std::max(std::abs(glm::dot(offset, right)) / halfX, std::abs(glm::dot(offset, above)) / halfY);
        distance = std::max(distance, sideways + glm::dot(offset, back));
    }
    // A box that is a point is looked at from as near as its place can still be told from the eye's.
    if (!(distance > 2.0 * leastSight(camera.target))) distance = 1e-6 * (1.0 + glm::length(camera.target));
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
    if (!(glm::length(sight) > leastSight(camera.eye))) {
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
