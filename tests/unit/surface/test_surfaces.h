// SPDX-License-Identifier: GPL-3.0-or-later
//
// Small surfaces for tests, as a job would have read them. Values.
#pragma once

#include <functional>
#include <memory>

#include "preprocess/mesh/triangle_mesh.h"
#include "preprocess/stipple/surface/walk_mesh.h"

namespace mote::test {

/// A mesh and what the builder makes of it; the walk refers to the mesh.
struct TestSurface {
    explicit TestSurface(const prep::TriangleMesh& raw) {
        prep::MeshCounts counts;
        const auto welded = prep::weldMesh(raw, counts);
        mesh = std::make_unique<storage::SurfaceMesh>(prep::makeSurfaceMesh(welded));
        walk = std::make_unique<prep::WalkMesh>(*mesh, prep::findNeighbours(welded.triangles));
    }

    std::unique_ptr<storage::SurfaceMesh> mesh;
    std::unique_ptr<prep::WalkMesh> walk;
};

/// A grid of columns x rows squares, two triangles each, `place` of (0..1, 0..1).
prep::TriangleMesh gridMesh(int columns, int rows, const std::function<glm::vec3(float, float)>& place);
/// Both meshes side by side.
prep::TriangleMesh together(prep::TriangleMesh first, const prep::TriangleMesh& second);

/// Radius 1, an octahedron whose triangles were divided into four `times` times.
prep::TriangleMesh sphere(int times);
/// Radii 1 and 0.4.
prep::TriangleMesh torus();
/// The unit square at a height, seen from above or, turned, from below.
prep::TriangleMesh square(float height, bool turned = false);

}  // namespace mote::test
