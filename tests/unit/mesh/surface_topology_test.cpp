// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/mesh/surface_topology.h"

#include <gmock/gmock.h>

#include <glm/geometric.hpp>

#include "tests/unit/mesh/sample_files.h"

namespace mote::test {
namespace {

using storage::MeshEdge;

prep::TriangleMesh weldedMeshOf(const std::string& obj) {
    auto read = readBytes({"mesh.obj", obj});
    EXPECT_TRUE(read.ok());
    return std::move(read->mesh);
}

/// The unit cube, a square a side.
const std::string cube =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

TEST(SurfaceTopology, ACubeHasFlatSidesAndClosedEdges) {
    const auto mesh = prep::makeSurfaceMesh(weldedMeshOf(cube));
    ASSERT_TRUE(storage::checkSurfaceMesh(mesh).ok());
    EXPECT_EQ(mesh.triangles.size(), 12U);
    EXPECT_EQ(mesh.positions.size(), 24U) << "four corners a side, each with the side's own normal";
    EXPECT_EQ(mesh.edges.size(), 18U) << "E = V + F - 2 of the 8 places and 12 triangles";
    for (const auto& edge : mesh.edges) EXPECT_NE(edge.triangles[1], MeshEdge::none);
    for (const auto& [a, b, c] : mesh.triangles) {
        const auto& p = mesh.positions;
        const auto normal = glm::normalize(glm::cross(p[b] - p[a], p[c] - p[a]));
        for (const auto v : {a, b, c}) EXPECT_NEAR(glm::dot(normal, mesh.normals[v]), 1.0F, 1e-6F);
        EXPECT_GT(glm::dot(normal, (p[a] + p[b] + p[c]) / 3.0F - glm::vec3(0.5F)), 0.0F) << "outwards";
    }
}

TEST(SurfaceTopology, BordersAndFansAreEdgesOfOneTriangle) {
    // Three triangles at one edge, as leaves of a book.
    const auto mesh = prep::makeSurfaceMesh(
        weldedMeshOf("v 0 0 0\nv 0 0 1\nv 1 0 0\nv 0 1 0\nv -1 -1 0\nf 1 2 3\nf 1 2 4\nf 1 2 5\n"));
    EXPECT_EQ(mesh.edges.size(), 9U);
    for (const auto& edge : mesh.edges) EXPECT_EQ(edge.triangles[1], MeshEdge::none);
}

TEST(SurfaceTopology, ASmoothSurfaceSharesItsVertices) {
    const auto mesh =
        prep::makeSurfaceMesh(weldedMeshOf("v 0 0 0\nv 1 0 0\nv 1 1 0.1\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"));
    EXPECT_EQ(mesh.positions.size(), 4U);
    EXPECT_EQ(mesh.edges.size(), 5U);
    const auto inner = std::find_if(mesh.edges.begin(), mesh.edges.end(),
                                    [](const auto& edge) { return edge.triangles[1] != MeshEdge::none; });
    ASSERT_NE(inner, mesh.edges.end());
    EXPECT_EQ(inner->triangles, (std::array<std::uint32_t, 2>{0, 1}));
}

TEST(SurfaceTopology, VerticesThatOnlyTouchAreApart) {
    // Two triangles with one corner in common.
    const auto mesh = prep::makeSurfaceMesh(
        weldedMeshOf("v 0 0 0\nv 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nf 1 2 3\nf 1 4 5\n"));
    EXPECT_EQ(mesh.positions.size(), 6U);
}

}  // namespace
}  // namespace mote::test
