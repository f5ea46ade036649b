// SPDX-License-Identifier: GPL-3.0-or-later
//
// Meshes that other people's programs wrote, against the counts that are known of them.
#include <gmock/gmock.h>

#include "preprocess/mesh/surface_topology.h"
#include "tests/support/must.h"
#include "tests/unit/mesh/sample_files.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;

struct Known {
    const char* file;
    std::uint64_t vertices;
    std::uint64_t triangles;
};

class RealMeshes : public testing::TestWithParam<Known> {};

TEST_P(RealMeshes, HaveTheirTriangles) {
    const auto path = fs::path(MOTE_SHARED_DATA) / "meshes" / GetParam().file;
    if (!fs::exists(path)) GTEST_SKIP() << "the real file is not here";
    QuietProgress progress;
    const auto read = must(prep::readMesh(path, std::uint64_t{1} << 30, progress));
    EXPECT_EQ(read.counts.vertices, GetParam().vertices);
    EXPECT_EQ(read.counts.triangles, GetParam().triangles);
    EXPECT_LE(read.counts.degenerate + read.counts.repeated, GetParam().triangles / 20);
    const auto mesh = prep::makeSurfaceMesh(read.mesh);
    EXPECT_TRUE(storage::checkSurfaceMesh(mesh).ok());
    EXPECT_GE(2 * mesh.edges.size(), 3 * mesh.triangles.size());
}

INSTANTIATE_TEST_SUITE_P(All, RealMeshes,
                         testing::Values(Known{"teapot.obj", 3644, 6320}, Known{"skull.obj", 49999, 100002},
                                         Known{"nefertiti_lowres.obj", 35002, 70000},
                                         Known{"spot.obj", 11533, 23062},
                                         Known{"tree_white_birch.obj.gz", 140124, 178908},
                                         Known{"tree_small_pine.obj.gz", 219088, 142382},
                                         Known{"ct_bones_spine_pelvis.ply.gz", 92517, 184170}),
                         [](const auto& sample) {
                             std::string name = sample.param.file;
                             return name.substr(0, name.find('.'));
                         });

}  // namespace
}  // namespace mote::test
