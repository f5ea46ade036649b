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
    std::vector<std::pair<std::uint64_t, Triangle>> keyed;
    keyed.reserve(mesh.triangles.size());
    for (const auto& triangle : mesh.triangles) {
        const glm::uvec3 cell(scale * (middle(mesh, triangle) - low));
        keyed.emplace_back(mortonKey(cell.x, cell.y, cell.z), triangle);
    }
    std::stable_sort(keyed.begin(), keyed.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t i = 0; i < keyed.size(); ++i) mesh.triangles[i] = keyed[i].second;
}

}  // namespace mote::prep
