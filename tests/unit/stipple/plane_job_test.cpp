// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>

#include "preprocess/stipple/stipple_job.h"
#include "storage/manifest.h"
#include "storage/stipple/stipple_hierarchy.h"
#include "storage/verify.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/stipple/test_progress.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

proto::JobRequest request(std::uint64_t points, std::uint64_t seed = 1) {
    proto::JobRequest request;
    request.mutable_stipple()->set_points(points);
    request.mutable_stipple()->set_seed(seed);
    return request;
}

Result<proto::Manifest> run(const proto::JobRequest& request, const fs::path& output, int threads = 0) {
    test::TestProgress progress;
    return runPlaneJob(request, output, {threads, 0}, progress);
}

std::string digestOf(const Result<proto::Manifest>& manifest) {
    return storage::findFile(*manifest, "hierarchy.h5")->xxh3_128();
}

TEST(PlaneJob, MakesADatasetThatIsWhole) {
    const test::TempDir dir;
    const auto made = run(request(300), dir / "a.mote");
    ASSERT_TRUE(made.ok()) << made.error().toString();
    EXPECT_TRUE(storage::verifyDataset(dir / "a.mote").empty());
    const auto manifest = storage::readManifest(dir / "a.mote");
    EXPECT_EQ(manifest->title(), "plane of 300 points");
    EXPECT_EQ(manifest->stipple().domain(), proto::StippleManifest::PLANE);
    EXPECT_EQ(manifest->stipple().seed(), 1U);
    const auto hierarchy = storage::readHierarchy(dir / "a.mote", *manifest);
    ASSERT_TRUE(hierarchy.ok()) << hierarchy.error().toString();
    EXPECT_EQ(hierarchy->size(), 300U);
}

TEST(PlaneJob, TheSameBytesOnAnyNumberOfThreads) {
    const test::TempDir dir;
    const auto one = digestOf(run(request(3000), dir / "one.mote", 1));
    EXPECT_EQ(digestOf(run(request(3000), dir / "four.mote", 4)), one);
    EXPECT_NE(digestOf(run(request(3000, 2), dir / "other.mote", 4)), one);
}

TEST(PlaneJob, OneToThreePoints) {
    const test::TempDir dir;
    for (std::uint64_t points = 1; points <= 3; ++points) {
        const auto output = dir / (std::to_string(points) + ".mote");
        ASSERT_TRUE(run(request(points), output).ok());
        EXPECT_TRUE(storage::verifyDataset(output).empty());
    }
}

TEST(PlaneJob, RefusesWhatCannotBeDone) {
    const test::TempDir dir;
    const auto refused = [&](const proto::JobRequest& asked, ErrorCode code, const std::string& where) {
        const auto made = run(asked, dir / "a.mote");
        ASSERT_FALSE(made.ok()) << where;
        EXPECT_EQ(made.error().code, code);
        EXPECT_EQ(made.error().where, where);
        EXPECT_TRUE(fs::is_empty(dir.path()));
    };
    refused(request(0), ErrorCode::invalidArgument, "points");
    refused(request(1ULL << 32), ErrorCode::invalidArgument, "points");
    refused(request(~0ULL), ErrorCode::invalidArgument, "points");
    refused(request(4000000000), ErrorCode::resourceExhausted, "points");
    auto rings = request(10);
    rings.mutable_stipple()->set_rings(3);
    refused(rings, ErrorCode::invalidArgument, "rings");
    for (const double wrong : {0.5, 2.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
        auto relaxation = request(10);
        relaxation.mutable_stipple()->set_relaxation(wrong);
        refused(relaxation, ErrorCode::invalidArgument, "relaxation");
    }
}

TEST(PlaneJob, LeavesNothingWhenItIsCancelled) {
    const test::TempDir dir;
    for (const double at : {0.0, 0.1, 0.6}) {
        test::TestProgress progress;
        progress.cancelAt(at);
        const auto made = runPlaneJob(request(3000), dir / "a.mote", {}, progress);
        ASSERT_FALSE(made.ok());
        EXPECT_EQ(made.error().code, ErrorCode::cancelled);
        EXPECT_TRUE(fs::is_empty(dir.path()));
    }
}

TEST(PlaneJob, SaysAtOnceThatTheOutputExists) {
    const test::TempDir dir;
    fs::create_directory(dir / "a.mote");
    test::TestProgress progress;
    progress.cancelAt(0.0);
    EXPECT_EQ(runPlaneJob(request(3000), dir / "a.mote", {}, progress).error().code,
              ErrorCode::alreadyExists);
}

}  // namespace
}  // namespace mote::prep
