// SPDX-License-Identifier: GPL-3.0-or-later
//
// MeshSurface: what a mesh layer is drawn from: a triangle mesh, and what finds it along rays. Made once for
// a dataset, immutable, shared by pictures.
#pragma once

#include "protocol/scene/bounds.h"
#include "server/render/layers/mesh/mesh_rays.h"
#include "storage/mesh/surface_mesh.h"

namespace mote::render {

class MeshSurface {
  public:
    /// `mesh`: a checked one; pairs of triangles that do not cut each other are left out. `bounds`: of its
    /// vertices. Throws std::bad_alloc.
    MeshSurface(storage::SurfaceMesh mesh, const Bounds& bounds);

    /// In layer space.
    const storage::SurfaceMesh& mesh() const { return mesh_; }
    const Bounds& bounds() const { return bounds_; }
    const MeshRays& rays() const { return rays_; }
    /// Of a vertex, or of an end of an intersection: that of number i has the ends V + 2 i and V + 2 i + 1
    /// behind the V vertices.
    glm::dvec3 place(std::uint32_t vertex) const {
        const std::size_t vertices = mesh_.positions.size();
        return vertex < vertices ? glm::dvec3(mesh_.positions[vertex]) : ends_[vertex - vertices];
    }

    /// That it takes in memory.
    std::uint64_t bytes() const;

  private:
    storage::SurfaceMesh mesh_;
    Bounds bounds_;
    MeshRays rays_;
    std::vector<glm::dvec3> ends_;  // of intersections
};

}  // namespace mote::render
