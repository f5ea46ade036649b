// SPDX-License-Identifier: GPL-3.0-or-later
//
// Places that are numbers, but absurd ones: no ray begins there.
#include <gmock/gmock.h>

#include "preprocess/mesh/triangle_mesh.h"
#include "storage/mesh/surface_mesh.h"

namespace mote::test {
namespace {

TEST(MeshPlaces, AnAbsurdPlaceIsRefused) {
    storage::SurfaceMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.normals.assign(3, {0, 0, 1});
    mesh.triangles = {{0, 1, 2}};
    for (const float far : {1e38F, -1e38F, 2e18F, std::numeric_limits<float>::quiet_NaN()}) {
        mesh.positions[1].x = far;
        const auto checked = storage::checkSurfaceMesh(mesh);
        ASSERT_FALSE(checked.ok()) << far;
        EXPECT_EQ(checked.error().where, "/mesh/position");
        EXPECT_THAT(checked.error().message, testing::HasSubstr("beyond 1e18"));
    }
    mesh.positions[1].x = 1e18F;
    EXPECT_TRUE(storage::checkSurfaceMesh(mesh).ok());
}

TEST(MeshPlaces, AJobLeavesOutWhatTheServerWouldRefuse) {
    prep::TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1e30F, 0, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 3, 2}};
    prep::MeshCounts counts;
    const auto welded = prep::weldMesh(std::move(mesh), counts);
    EXPECT_EQ(welded.triangles.size(), 1U);
    EXPECT_EQ(counts.notFinite, 1U);
}

}  // namespace
}  // namespace mote::test
