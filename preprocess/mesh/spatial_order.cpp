// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/mesh/spatial_order.h"

#include <algorithm>
#include <glm/common.hpp>
#include <limits>
#include <utility>

#include "preprocess/particles/cell_plan.h"

namespace mote::prep {
namespace {

constexpr double cellsAcross = 2097151.0;  // 2^21 - 1, of the box's longest side

glm::dvec3 middle(const TriangleMesh& mesh, const Triangle& triangle) {
    return (glm::dvec3(mesh.positions[triangle[0]]) + glm::dvec3(mesh.positions[triangle[1]]) +
            glm::dvec3(mesh.positions[triangle[2]])) /
           3.0;
}

/// Of each triangle, its key and its number.
template <class T>
std::vector<T> inOrder(const std::vector<T>& values,
                       const std::vector<std::pair<std::uint64_t, std::uint32_t>>& keyed) {
    std::vector<T> made;
    made.reserve(values.size());
    for (const auto& [key, triangle] : keyed) made.push_back(values[triangle]);
    return made;
}

}  // namespace

void orderInSpace(TriangleMesh& mesh) {
    glm::dvec3 low(std::numeric_limits<double>::infinity());
    glm::dvec3 high = -low;
    for (const auto& position : mesh.positions) {
        low = glm::min(low, glm::dvec3(position));
        high = glm::max(high, glm::dvec3(position));
    }
    const double side = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
    const double scale = side > 0.0 ? cellsAcross / side : 0.0;
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed;
    keyed.reserve(mesh.triangles.size());
    for (const auto& triangle : mesh.triangles) {
        const glm::uvec3 cell(scale * (middle(mesh, triangle) - low));
        keyed.emplace_back(mortonKey(cell.x, cell.y, cell.z), static_cast<std::uint32_t>(keyed.size()));
    }
    std::sort(keyed.begin(), keyed.end());
    mesh.triangles = inOrder(mesh.triangles, keyed);
    if (!mesh.parts.empty()) mesh.parts = inOrder(mesh.parts, keyed);
}

}  // namespace mote::prep
