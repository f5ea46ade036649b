// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/reference/mesh_hits.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "protocol/scene/fields/facts.h"
#include "protocol/scene/write_fields.h"

namespace mote::reference {
namespace {

constexpr double farthestHit = std::numeric_limits<double>::infinity();
/// Where a pixel is looked through, sixteenths of it from its centre: written down once more, see PICTURE.md.
constexpr std::array<std::array<double, 2>, 8> samples{
    {{1, -3}, {-1, 3}, {5, 1}, {-3, -5}, {-5, 5}, {-7, -1}, {3, 7}, {7, -7}}};

double determinant(const std::array<glm::dvec3, 3>& rows) {
    return glm::dot(rows[0], glm::cross(rows[1], rows[2]));
}

}  // namespace

MeshHits::MeshHits(const View& view, const Layer& layer, const render::MeshSurface& surface)
    : view_(view),
      layer_(layer),
      style_(*layer.mesh()),
      shading_(lightOf(style_.light())),
      color_(readColor(style_.color())),
      halfWire_(0.5 * lengthOf(style_, style_.kWireWidthFieldNumber)),
      opacity_(style_.opacity() * layer.opacity),
      toEye_(view.camera.worldToEye() * layer.transform),
      gap_(1e-4 * glm::length(surface.bounds().size())),
      pixels_(view.height / (2.0 * view.camera.halfHeight())),
      light_(shading_.direction) {
    if (shading_.fixed) light_ = glm::normalize(glm::dmat3(view.camera.worldToEye()) * light_);
    lightInLayer_ = glm::inverse(glm::dmat3(toEye_)) * light_;
    for (const auto& vertices : surface.mesh().triangles)
        triangles_.push_back(triangleOf(surface.mesh(), vertices));
}

MeshHits::Triangle MeshHits::triangleOf(const storage::SurfaceMesh& mesh,
                                        const std::array<std::uint32_t, 3>& vertices) const {
    const glm::dmat3 normalToEye = glm::transpose(glm::inverse(glm::dmat3(toEye_)));
    const bool perspective = view_.camera.perspective();
    Triangle made;
    made.low = glm::dvec2(farthestHit);
    made.high = glm::dvec2(-farthestHit);
    for (std::size_t i = 0; i < 3; ++i) {
        made.inLayer[i] = mesh.positions[vertices[i]];
        made.normals[i] = normalToEye * glm::dvec3(mesh.normals[vertices[i]]);
        const glm::dvec3 eye(toEye_ * glm::dvec4(made.inLayer[i], 1.0));
        made.corners[i] = eye;
        made.inWindow[i] = {eye.x, eye.y, perspective ? -eye.z : 1.0};
        const glm::dvec2 place = glm::dvec2(0.5 * view_.width, 0.5 * view_.height) +
                                 pixels_ / made.inWindow[i].z * glm::dvec2(eye.x, -eye.y);
        made.low = glm::min(made.low, place);
        made.high = glm::max(made.high, place);
    }
    const auto behind = [](const glm::dvec3& at) { return !(at.z > 0.0); };
    if (std::any_of(made.inWindow.begin(), made.inWindow.end(), behind)) {
        made.low = glm::dvec2(-farthestHit);
        made.high = glm::dvec2(farthestHit);
    }
    return made;
}

bool MeshHits::nearEdge(const Triangle& triangle, const glm::dvec3& window) const {
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec3 line = glm::cross(triangle.inWindow[i], triangle.inWindow[(i + 1) % 3]);
        const double distance = std::abs(glm::dot(line, window)) / std::hypot(line.x, line.y);
        if (distance * pixels_ <= halfWire_) return true;
    }
    return false;
}

/// By Moeller and Trumbore's way, in layer space.
bool MeshHits::inShadow(const glm::dvec3& place) const {
    return std::any_of(triangles_.begin(), triangles_.end(), [&](const Triangle& triangle) {
        const auto& [a, b, c] = triangle.inLayer;
        const glm::dvec3 right = b - a, left = c - a, across = glm::cross(lightInLayer_, left);
        const double scale = glm::dot(right, across);
        if (scale == 0.0) return false;
        const double u = glm::dot(place - a, across) / scale;
        const glm::dvec3 turned = glm::cross(place - a, right);
        const double v = glm::dot(lightInLayer_, turned) / scale;
        const double at = glm::dot(left, turned) / scale;
        return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && at >= 0.0 &&
               !cutAway(layer_, place + at * lightInLayer_);
    });
}

glm::dvec3 MeshHits::shade(const glm::dvec3& normal, const glm::dvec3& towardsEye, bool dark) const {
    const Light& light = shading_;
    const double facing = dark ? 0.0 : std::max(0.0, glm::dot(normal, light_));
    glm::dvec3 color = std::min(1.0, light.ambient + light.diffuse * facing) * color_;
    const glm::dvec3 half = light_ + towardsEye;
    if (!dark && glm::length(half) > 0.0)
        color += light.specular * std::pow(std::max(0.0, glm::dot(normal, glm::normalize(half))), 32.0);
    return color;
}

/// A ray meets the plane of a triangle within it where it passes its three edges on one side; how far along
/// the window's depth, Cramer's rule tells.
void MeshHits::meet(const Triangle& triangle, const glm::dvec2& at, std::size_t sample,
                    std::vector<Met>& met) const {
    const glm::dvec3 window((at.x - 0.5 * view_.width) / pixels_, (0.5 * view_.height - at.y) / pixels_, 1.0);
    const auto& [a, b, c] = triangle.inWindow;
    const glm::dvec3 sides(glm::dot(glm::cross(b, c), window), glm::dot(glm::cross(c, a), window),
                           glm::dot(glm::cross(a, b), window));
    const bool within = (sides.x >= 0.0 && sides.y >= 0.0 && sides.z >= 0.0) ||
                        (sides.x <= 0.0 && sides.y <= 0.0 && sides.z <= 0.0);
    const double sum = sides.x + sides.y + sides.z;
    if (!within || sum == 0.0 || determinant(triangle.inWindow) == 0.0) return;
    const glm::dvec3 weights = sides / sum;
    const auto mixed = [&](const std::array<glm::dvec3, 3>& values) {
        return weights.x * values[0] + weights.y * values[1] + weights.z * values[2];
    };
    const bool perspective = view_.camera.perspective();
    const double depth = perspective ? determinant(triangle.inWindow) / sum : -mixed(triangle.corners).z;
    if (depth < nearestDepth(view_.camera)) return;
    if (style_.wire() && !nearEdge(triangle, window)) return;
    if (cutAway(layer_, mixed(triangle.inLayer))) return;

    const glm::dvec3 away = perspective ? glm::dvec3(window.x, window.y, -1.0) : glm::dvec3(0.0, 0.0, -1.0);
    const auto areaOf = [](const std::array<glm::dvec3, 3>& p) {
        return glm::cross(p[1] - p[0], p[2] - p[0]);
    };
    // Counterclockwise from outside, in layer space: a mirror image turns it round.
    const double mirrored = glm::determinant(glm::dmat3(toEye_)) < 0.0 ? -1.0 : 1.0;
    const double side = mirrored * glm::dot(areaOf(triangle.corners), away) > 0.0 ? -1.0 : 1.0;
    glm::dvec3 normal = mixed(triangle.normals);
    if (normal == glm::dvec3(0.0)) normal = mirrored * areaOf(triangle.corners);
    normal = side * glm::normalize(normal);
    const glm::dvec3 off = side * gap_ * glm::normalize(areaOf(triangle.inLayer));
    const bool dark =
        shading_.shadow && glm::dot(normal, light_) > 0.0 && inShadow(mixed(triangle.inLayer) + off);
    met.push_back({depth, sample, shade(normal, -glm::normalize(away), dark)});
}

void MeshHits::addPixel(std::uint32_t column, std::uint32_t row, const std::vector<const Triangle*>& near,
                        std::vector<Hit>& hits) const {
    std::vector<Met> met;
    for (const Triangle* const triangle : near) {
        if (triangle->high.x < column || triangle->low.x > column + 1.0) continue;
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const glm::dvec2 at(column + 0.5 + samples[i][0] / 16.0, row + 0.5 + samples[i][1] / 16.0);
            meet(*triangle, at, i, met);
        }
    }
    std::stable_sort(met.begin(), met.end(), [](const Met& a, const Met& b) { return a.depth < b.depth; });
    std::array<double, samples.size()> left{};
    left.fill(1.0);
    double all = samples.size();
    for (const auto& one : met) {
        const double lost = left[one.sample] * opacity_;
        if (lost > 0.0) hits.push_back({column, one.depth, std::min(lost / all, 1.0), one.color});
        left[one.sample] -= lost;
        all -= lost;
    }
}

void MeshHits::addRow(std::uint32_t row, std::vector<Hit>& hits) const {
    std::vector<const Triangle*> near;
    for (const auto& triangle : triangles_) {
        if (triangle.high.y >= row && triangle.low.y <= row + 1.0) near.push_back(&triangle);
    }
    if (near.empty()) return;
    for (std::uint32_t column = 0; column < view_.width; ++column) addPixel(column, row, near, hits);
}

}  // namespace mote::reference
