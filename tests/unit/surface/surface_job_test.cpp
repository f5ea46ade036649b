// SPDX-License-Identifier: GPL-3.0-or-later
//
// The stipple job on a mesh, from the file to the dataset.
#include "preprocess/stipple/surface/surface_job.h"

#include <gmock/gmock.h>

#include <fstream>

#include "storage/manifest.h"
#include "storage/mesh/mesh_file.h"
#include "storage/stipple/stipple_hierarchy.h"
#include "storage/verify.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/particles/quiet_progress.h"
#include "tests/unit/surface/test_surfaces.h"

namespace mote::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

class SurfaceJob : public testing::Test {
  protected:
    void SetUp() override {
        std::ofstream file(input_);
        const auto mesh = sphere(3);
        for (const auto& p : mesh.positions) file << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
        for (const auto& [a, b, c] : mesh.triangles) {
            file << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << '\n';
        }
        request_.mutable_stipple()->set_mesh(input_.string());
        request_.mutable_stipple()->set_points(400);
        request_.mutable_stipple()->set_seed(7);
    }
    Result<proto::Manifest> run(const std::string& name, prep::Progress& progress,
                                const prep::JobResources& options = {}) {
        return prep::runSurfaceJob(request_, input_, folder_ / name, options, progress);
    }
    std::string bytesOf(const fs::path& name) const {
        std::ifstream file(folder_ / name, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    long entries() const {
        return std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator());
    }

    TempDir folder_;
    fs::path input_ = folder_ / "ball.obj";
    proto::JobRequest request_;
    QuietProgress progress_;
};

TEST_F(SurfaceJob, MakesAHierarchyBesideItsMesh) {
    const auto made = run("ball.mote", progress_);
    ASSERT_TRUE(made.ok()) << made.error().toString();
    EXPECT_TRUE(std::is_sorted(progress_.fractions.begin(), progress_.fractions.end()));
    EXPECT_DOUBLE_EQ(progress_.fractions.back(), 1.0);
    const auto manifest = storage::readManifest(folder_ / "ball.mote");
    ASSERT_TRUE(manifest.ok()) << manifest.error().toString();
    EXPECT_EQ(manifest->kind(), "stipple");
    EXPECT_EQ(manifest->stipple().domain(), proto::StippleManifest::SURFACE);
    EXPECT_EQ(manifest->request().stipple().mesh(), "ball.obj");
    EXPECT_DOUBLE_EQ(manifest->stipple().area(), manifest->mesh().area());
    const auto mesh = storage::readMesh(folder_ / "ball.mote", *manifest);
    ASSERT_TRUE(mesh.ok()) << mesh.error().toString();
    EXPECT_EQ(mesh->triangles.size(), 512U);
    const auto hierarchy = storage::readHierarchy(folder_ / "ball.mote", *manifest);
    ASSERT_TRUE(hierarchy.ok()) << hierarchy.error().toString();
    EXPECT_EQ(hierarchy->size(), 400U);
    EXPECT_GT(manifest->stipple().locked(), 0U) << "the last ones on a sphere cannot see it flat";
    EXPECT_LT(manifest->stipple().locked(), 200U);
    EXPECT_THAT(storage::verifyDataset(folder_ / "ball.mote"), IsEmpty());
}

TEST_F(SurfaceJob, TheSameSeedMakesTheSameBytes) {
    ASSERT_TRUE(run("a.mote", progress_, {1, 0}).ok());
    QuietProgress again;
    ASSERT_TRUE(run("b.mote", again, {3, 0}).ok());
    for (const auto* file : {"hierarchy.h5", "hierarchy.digest", "mesh.h5", "manifest.json"}) {
        EXPECT_EQ(bytesOf(fs::path("a.mote") / file), bytesOf(fs::path("b.mote") / file)) << file;
    }
}

TEST_F(SurfaceJob, MorePointsThanMemoryIsSaidAtOnce) {
    request_.mutable_stipple()->set_points(1000000);
    const auto made = run("a.mote", progress_, {0, 64 << 20});
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().code, ErrorCode::resourceExhausted);
    EXPECT_THAT(made.error().toString(), HasSubstr("1000000 points"));
    EXPECT_EQ(entries(), 1);
}

TEST_F(SurfaceJob, FailuresLeaveNothing) {
    QuietProgress cancelling(5);
    EXPECT_EQ(run("a.mote", cancelling).error().code, ErrorCode::cancelled);
    std::ofstream(input_) << "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n";
    const auto flat = run("a.mote", progress_);
    ASSERT_FALSE(flat.ok());
    EXPECT_THAT(flat.error().toString(), HasSubstr("1 triangles without area"));
    EXPECT_EQ(entries(), 1);
}

}  // namespace
}  // namespace mote::test
