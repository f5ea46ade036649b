// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/mesh/mesh_surface.h"

#include <utility>

#include "storage/mesh/triangle_intersection.h"

namespace mote::render {

MeshSurface::MeshSurface(storage::SurfaceMesh mesh, const Bounds& bounds)
    : mesh_(std::move(mesh)), bounds_(bounds), rays_(mesh_, bounds) {
    const storage::TriangleIntersections rule(mesh_);
    std::erase_if(mesh_.intersections, [&](const auto& pair) {
        const auto line = rule.between(pair[0], pair[1]);
        if (line) ends_.insert(ends_.end(), line->begin(), line->end());
        return !line;
    });
}

std::uint64_t MeshSurface::bytes() const {
    return 2 * mesh_.positions.size() * sizeof(glm::vec3) +
           mesh_.triangles.size() * sizeof(mesh_.triangles[0]) + mesh_.edges.size() * sizeof(mesh_.edges[0]) +
           mesh_.parts.size() * sizeof(mesh_.parts[0]) +
           mesh_.intersections.size() * sizeof(mesh_.intersections[0]) + ends_.size() * sizeof(ends_[0]) +
           rays_.bytes();
}

}  // namespace mote::render
