// SPDX-License-Identifier: GPL-3.0-or-later
//
// A mesh on disk: what comes back is what was written, and damage is found.
#include <gmock/gmock.h>

#include <fstream>

#include "preprocess/mesh/mesh_job.h"
#include "preprocess/mesh/surface_topology.h"
#include "storage/manifest.h"
#include "storage/mesh/mesh_file.h"
#include "storage/verify.h"
#include "tests/support/must.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/mesh/sample_files.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

class MeshDataset : public testing::Test {
  protected:
    void SetUp() override {
        const auto sample = tetrahedronFiles().front();
        std::ofstream(input_) << sample.bytes;
        proto::JobRequest request;
        request.mutable_mesh()->set_input(input_.string());
        const auto made = must(prep::runMeshJob(request, input_, dataset_, {}, progress_));
    }

    TempDir folder_;
    fs::path input_ = folder_ / "tetrahedron.obj";
    fs::path dataset_ = folder_ / "a.mote";
    QuietProgress progress_;
};

TEST_F(MeshDataset, ComesBackAsItWas) {
    const auto manifest = must(storage::readManifest(dataset_));
    EXPECT_EQ(manifest.kind(), "mesh");
    EXPECT_EQ(manifest.request().mesh().input(), "tetrahedron.obj");
    // Three right triangles of area 1/2 and the slanted one, sqrt(3) / 2; from 32-bit corners, summed as
    // doubles.
    EXPECT_NEAR(manifest.mesh().area(), 1.5 + std::sqrt(3.0) / 2.0, 1e-14);
    const auto mesh = must(storage::readMesh(dataset_, manifest));
    const auto wanted = prep::makeSurfaceMesh(readBytes(tetrahedronFiles().front())->mesh);
    EXPECT_EQ(mesh.positions, wanted.positions);
    EXPECT_EQ(mesh.normals, wanted.normals);
    EXPECT_EQ(mesh.triangles, wanted.triangles);
    EXPECT_EQ(mesh.edges, wanted.edges);
    EXPECT_EQ(mesh.parts, wanted.parts);
    EXPECT_THAT(storage::verifyDataset(dataset_), IsEmpty());
}

TEST_F(MeshDataset, DamageIsFound) {
    const auto manifest = *storage::readManifest(dataset_);
    {
        std::fstream file(dataset_ / "mesh.h5", std::ios::binary | std::ios::in | std::ios::out);
        file.seekp(-20, std::ios::end);
        file.write("damaged", 7);
    }
    const auto mesh = storage::readMesh(dataset_, manifest);
    ASSERT_FALSE(mesh.ok());
    EXPECT_EQ(mesh.error().code, ErrorCode::corrupt);
    EXPECT_THAT(mesh.error().where, HasSubstr("mesh.h5:/mesh/"));
    EXPECT_FALSE(storage::verifyDataset(dataset_).empty());
    fs::resize_file(dataset_ / "mesh.h5", 100);
    EXPECT_EQ(storage::readMesh(dataset_, manifest).error().code, ErrorCode::corrupt);
}

TEST_F(MeshDataset, AManifestThatLiesIsRefused) {
    auto manifest = *storage::readManifest(dataset_);
    manifest.mutable_mesh()->set_triangles(5);
    EXPECT_EQ(storage::readMesh(dataset_, manifest).error().code, ErrorCode::corrupt);
    EXPECT_TRUE(storage::checkManifest(manifest).ok());
    manifest.mutable_mesh()->set_area(-1.0);
    EXPECT_EQ(storage::checkManifest(manifest).error().where, "mesh.area");
    manifest.clear_mesh();
    EXPECT_EQ(storage::checkManifest(manifest).error().code, ErrorCode::unsupported);
    EXPECT_EQ(storage::readMesh(dataset_, manifest).error().code, ErrorCode::invalidArgument);
}

TEST_F(MeshDataset, AFailedJobLeavesNothing) {
    std::ofstream(folder_ / "bad.obj") << "v 0 0 0\nf 1 2 3\n";
    proto::JobRequest request;
    EXPECT_FALSE(prep::runMeshJob(request, folder_ / "bad.obj", folder_ / "b.mote", {}, progress_).ok());
    QuietProgress cancelling(0);
    EXPECT_EQ(prep::runMeshJob(request, input_, folder_ / "b.mote", {}, cancelling).error().code,
              ErrorCode::cancelled);
    const auto entries = std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator());
    EXPECT_EQ(entries, 3) << "the two inputs and the first dataset";
}

}  // namespace
}  // namespace mote::test
