// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/mesh/mesh_sight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <utility>

#include "protocol/scene/fields/facts.h"
#include "protocol/scene/write_fields.h"

namespace mote::render {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// Of the bounds' diagonal: rays towards the light start this far off the surface (docs/PICTURE.md).
constexpr double shadowGap = 1e-4;

}  // namespace

/// Of a triangle, layer space.
struct MeshSight::Corners {
    glm::dvec3 a, b, c;
};

MeshSight::MeshSight(const FramePlan& plan, const glm::dmat4& transform, const MeshStyle& style,
                     const MeshSurface& surface, double pixels, HalfSpaces clips)
    : color_(readColor(style.color())),
      wire_(style.wire()),
      parts_(lightOf(style.light())),
      surface_(surface),
      clips_(std::move(clips)),
      perspective_(plan.camera.perspective()),
      nearest_(nearLimit(plan.camera)),
      size_(plan.width, plan.height),
      pixels_(plan.height / (2.0 * plan.camera.halfHeight())),
      halfLine_(0.5 *
                std::max(lengthOf(style, style.kWireWidthFieldNumber) * pixels, plan.exact ? 0.0 : 1.0)),
      toEye_(plan.camera.worldToEye() * transform),
      fromEye_(glm::inverse(toEye_)) {
    const glm::dmat3 linear(toEye_);
    // The cofactors; a mirror image keeps outside out.
    areaToEye_ = std::abs(glm::determinant(linear)) * glm::transpose(glm::inverse(linear));
    light_ = parts_.fixed ? glm::normalize(glm::dmat3(plan.camera.worldToEye()) * parts_.direction)
                          : parts_.direction;
    lightInLayer_ = glm::normalize(glm::dmat3(fromEye_) * light_);
    shadowGap_ = shadowGap * glm::length(surface.bounds().size());
    const Bounds inEye = surface.bounds().transformed(toEye_);
    nearDepth_ = std::max(-inEye.max.z, nearest_);
    farDepth_ = std::max(-inEye.min.z, nearest_);
    start_ = perspective_ ? 0.0 : 0.5 * (nearDepth_ + farDepth_);
}

SightRay MeshSight::through(double x, double y) const {
    SightRay ray;
    ray.window = glm::dvec2(x - 0.5 * size_.x, 0.5 * size_.y - y) / pixels_;
    const glm::dvec3 origin = perspective_ ? glm::dvec3(0.0) : glm::dvec3(ray.window, -start_);
    const glm::dvec3 perDepth = perspective_ ? glm::dvec3(ray.window, -1.0) : glm::dvec3(0.0, 0.0, -1.0);
    ray.inLayer = {glm::dvec3(fromEye_ * glm::dvec4(origin, 1.0)),
                   glm::dvec3(fromEye_ * glm::dvec4(perDepth, 0.0)), nearest_ - start_, infinity};
    ray.inLayer.clip(surface_.rays().box());
    ray.inLayer.clip(clips_);
    return ray;
}

std::optional<MeshHit> MeshSight::hit(const SightRay& ray, const MeshMeeting& met) const {
    const auto& mesh = surface_.mesh();
    const auto [i, j, k] = mesh.triangles[met.triangle];
    const Corners corners{mesh.positions[i], mesh.positions[j], mesh.positions[k]};
    if (wire_ && !onWire(ray.window, corners)) return std::nullopt;
    const glm::dvec3 area = glm::cross(corners.b - corners.a, corners.c - corners.a);
    const glm::dvec3 smooth = met.weights.x * glm::dvec3(mesh.normals[i]) +
                              met.weights.y * glm::dvec3(mesh.normals[j]) +
                              met.weights.z * glm::dvec3(mesh.normals[k]);
    // Both sides of a surface are lit: its normals are turned to the side that is seen.
    const double side = glm::dot(area, ray.inLayer.direction) > 0.0 ? -1.0 : 1.0;
    const glm::dvec3 flat = areaToEye_ * area, turned = areaToEye_ * smooth;
    const glm::dvec3 normal = side * glm::normalize(glm::dot(turned, turned) > 0.0 ? turned : flat);
    const glm::dvec3 towardsEye =
        perspective_ ? glm::normalize(glm::dvec3(-ray.window, 1.0)) : glm::dvec3(0.0, 0.0, 1.0);
    const bool dark = parts_.shadow && glm::dot(normal, light_) > 0.0 &&
                      shadowed(ray.inLayer.origin + met.at * ray.inLayer.direction, side * area);
    return MeshHit{start_ + met.at, shade(normal, towardsEye, dark), normal};
}

/// Within half a line of an edge of the triangle. The line through two corners on the screen is where the
/// plane through them and the eye meets the window, also if they lie behind the eye.
bool MeshSight::onWire(const glm::dvec2& window, const Corners& corners) const {
    const auto inWindow = [&](const glm::dvec3& inLayer) {
        const glm::dvec3 eye(toEye_ * glm::dvec4(inLayer, 1.0));
        return glm::dvec3(eye.x, eye.y, perspective_ ? -eye.z : 1.0);
    };
    const std::array<glm::dvec3, 3> at{inWindow(corners.a), inWindow(corners.b), inWindow(corners.c)};
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec3 line = glm::cross(at[i], at[(i + 1) % 3]);
        const double distance = std::abs(glm::dot(line, glm::dvec3(window, 1.0)));
        if (distance * pixels_ <= halfLine_ * glm::length(glm::dvec2(line))) return true;
    }
    return false;
}

/// `side`: a normal of the triangle, on the side that is seen.
bool MeshSight::shadowed(const glm::dvec3& place, const glm::dvec3& side) const {
    MeshRay ray{place + shadowGap_ * glm::normalize(side), lightInLayer_, 0.0, infinity};
    ray.clip(surface_.rays().box());
    ray.clip(clips_);
    return !ray.empty() && surface_.rays().blocked(ray);
}

glm::dvec3 MeshSight::shade(const glm::dvec3& normal, const glm::dvec3& towardsEye, bool shadowed) const {
    if (shadowed) return std::min(1.0, parts_.ambient) * color_;
    const double diffuse = parts_.diffuse * std::max(0.0, glm::dot(normal, light_));
    const glm::dvec3 color = std::min(1.0, parts_.ambient + diffuse) * color_;
    const glm::dvec3 half = light_ + towardsEye;
    const double length = glm::length(half);
    if (!(parts_.specular > 0.0 && length > 0.0)) return color;
    double shine = std::max(0.0, glm::dot(normal, half / length));
    for (int i = 0; i < 5; ++i) shine *= shine;  // to the power of 32, alike on every processor
    return color + parts_.specular * shine;
}

PixelRect MeshSight::touched() const {
    const Bounds& box = surface_.bounds();
    glm::dvec2 low(infinity), high(-infinity);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 at((corner & 1) != 0 ? box.max.x : box.min.x,
                            (corner & 2) != 0 ? box.max.y : box.min.y,
                            (corner & 4) != 0 ? box.max.z : box.min.z);
        const glm::dvec3 eye(toEye_ * glm::dvec4(at, 1.0));
        // Beside the eye a box has no outline.
        if (perspective_ && -eye.z <= nearest_) return {0, 0, unsigned(size_.x), unsigned(size_.y)};
        const glm::dvec2 place =
            0.5 * size_ + pixels_ / (perspective_ ? -eye.z : 1.0) * glm::dvec2(eye.x, -eye.y);
        low = glm::min(low, place);
        high = glm::max(high, place);
    }
    const auto held = [](double at, double most) {
        return static_cast<std::uint32_t>(std::clamp(at, 0.0, most));
    };
    return {held(std::floor(low.x) - 1.0, size_.x), held(std::floor(low.y) - 1.0, size_.y),
            held(std::ceil(high.x) + 1.0, size_.x), held(std::ceil(high.y) + 1.0, size_.y)};
}

}  // namespace mote::render
