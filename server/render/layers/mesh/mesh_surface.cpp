// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/mesh/mesh_surface.h"

#include <utility>

namespace mote::render {

MeshSurface::MeshSurface(storage::SurfaceMesh mesh, const Bounds& bounds)
    : mesh_(std::move(mesh)), bounds_(bounds), rays_(mesh_, bounds) {}

std::uint64_t MeshSurface::bytes() const {
    return 2 * mesh_.positions.size() * sizeof(glm::vec3) +
           mesh_.triangles.size() * sizeof(mesh_.triangles[0]) + mesh_.edges.size() * sizeof(mesh_.edges[0]) +
           mesh_.parts.size() * sizeof(mesh_.parts[0]) + rays_.bytes();
}

}  // namespace mote::render
