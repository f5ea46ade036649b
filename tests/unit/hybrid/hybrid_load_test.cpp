// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

#include "preprocess/export_vdb.h"
#include "server/render/layers/hybrid/hybrid_load.h"
#include "storage/hybrid/hybrid_limits.h"
#include "storage/manifest.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/hybrid/small_hybrid.h"
#include "tests/unit/hybrid/volume_job_run.h"

namespace mote::render {
namespace {

using test::smallManifest;
using test::smallPoints;
using enum HybridRepresentation;

class HybridLoad : public testing::Test {
  protected:
    HybridLoad() {
        test::writeSmallHybrid(dir_ / "a.mote", smallPoints(5), smallManifest(5, 8));
        manifest_ = storage::readManifest(dir_ / "a.mote").value();
    }
    std::shared_ptr<const GridField> load(HybridRepresentation representation) {
        auto step = loadHybrid(dir_ / "a.mote", manifest_, 0, representation);
        EXPECT_TRUE(step.ok()) << step.error().toString();
        return *step;
    }
    /// The low volume at a sample of the error grid: sample (x, y, z) has the value x + 4 y + 12 z - 7.
    double lowAt(const glm::uvec3& at) const {
        double sum = -7.0;
        const double steps[3] = {1.0, 4.0, 12.0};
        const std::uint32_t low[3] = {4, 3, 2};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto size = test::smallErrorGrid[axis];
            const auto i = at[static_cast<int>(axis)];
            const auto place = storage::between(storage::placeIn(i, size, low[axis]), low[axis]);
            sum += steps[axis] * (place.first + double{place.fraction} * (place.second - place.first));
        }
        return sum;
    }

    test::TempDir dir_;
    proto::Manifest manifest_;
};

TEST_F(HybridLoad, TakesOnlyWhatIsDrawn) {
    const auto low = load(volume);
    EXPECT_FALSE(low->bricks);
    EXPECT_EQ(low->parts, volume);
    EXPECT_EQ(low->coarse.size, glm::uvec3(4, 3, 2));
    EXPECT_NEAR(low->valueOf(low->coarse.values[23]), 16.0, 255.0 / 65535.0);
    EXPECT_EQ(low->coarse.normals[1], 4);
    for (const auto parts : {points, residual}) {
        EXPECT_TRUE(load(parts)->bricks);
        EXPECT_EQ(load(parts)->parts, parts);
    }
}

TEST_F(HybridLoad, TheBoxIsWhereTheVoxelsAre) {
    const auto step = load(volume);
    EXPECT_EQ(step->bounds(), (Bounds{glm::dvec3(-0.5), glm::dvec3(139.5, 79.5, 65.5)}));
    EXPECT_EQ(step->longestEdge(), 140.0);
}

/// A sample of a brick.
struct Placed {
    const GridBricks& bricks;
    glm::uvec3 brick, sample;

    std::size_t index() const {
        const auto number = bricks.numbers[bricks.index(brick)];
        EXPECT_NE(number, GridBricks::none);
        return static_cast<std::size_t>(number) * GridBricks::volume + (sample.z * 9 + sample.y) * 9 +
               sample.x;
    }
    std::uint16_t code() const { return bricks.values[index()]; }
    std::uint8_t normal() const { return bricks.normals[index()]; }
};

TEST_F(HybridLoad, PointsAreInTheirBricksWithValuesAndNormals) {
    const auto step = load(points);
    const auto& bricks = *step->bricks;
    EXPECT_EQ(bricks.size, glm::uvec3(70, 40, 33));
    // Point 3 lies at (32, 39, 5), where a brick begins along x, so it is the last sample of the one before.
    for (const Placed& place : {Placed{bricks, {4, 4, 0}, {0, 7, 5}}, Placed{bricks, {3, 4, 0}, {8, 7, 5}}}) {
        EXPECT_EQ(place.code(), 150 * 257);
        EXPECT_EQ(place.normal(), 3);
    }
    // Point 1 lies at (31, 31, 31); beside it there is the low volume.
    EXPECT_EQ((Placed{bricks, {3, 3, 3}, {7, 7, 7}}.code()), 50 * 257);
    const double beside = step->valueOf(Placed{bricks, {3, 3, 3}, {6, 7, 7}}.code());
    EXPECT_NEAR(beside, lowAt({30, 31, 31}), 1.1 * 255.0 / 65535.0);
    // Beyond the grid's end, which is the last point's, there is the same.
    EXPECT_EQ((Placed{bricks, {8, 4, 4}, {1, 7, 2}}.code()), (Placed{bricks, {8, 4, 4}, {1, 7, 1}}.code()));
    // (0, 0, 0); (31, 31, 31); (69, 1, 2); (32, 39, 5) and before it; (64, 39, 32) and the three before it.
    EXPECT_EQ(bricks.corrected(), 1U + 1U + 1U + 2U + 4U);
}

TEST_F(HybridLoad, AllFormsOfPointsAreTheSame) {
    const auto expected = load(points);
    for (const int bytes : {6, 9}) {
        const auto name = "b" + std::to_string(bytes) + ".mote";
        test::writeSmallHybrid(dir_ / name, smallPoints(bytes), smallManifest(bytes, 8));
        const auto other =
            loadHybrid(dir_ / name, storage::readManifest(dir_ / name).value(), 0, points).value();
        EXPECT_EQ(other->bricks->numbers, expected->bricks->numbers);
        EXPECT_EQ(other->bricks->values, expected->bricks->values);
        EXPECT_EQ(other->bricks->normals, expected->bricks->normals);
    }
}

TEST_F(HybridLoad, BricksAreTheLowVolumeWithWhatIsAdded) {
    const auto step = load(residual);
    const auto& bricks = *step->bricks;
    EXPECT_EQ(bricks.count, glm::uvec3(9, 5, 5));
    const auto at = [&](const glm::uvec3& brick, const glm::uvec3& sample) {
        return step->valueOf(Placed{bricks, brick, sample}.code());
    };
    // Codes of 16 bits over 255, of the low volume and of the sum.
    constexpr double quantisation = 1.1 * 255.0 / 65535.0;
    EXPECT_NEAR(at({0, 1, 2}, {0, 0, 0}), std::max(lowAt({0, 8, 16}) - 24.0, -10.0), quantisation);
    EXPECT_NEAR(at({0, 1, 2}, {2, 5, 7}), lowAt({2, 13, 23}) + 136.0, quantisation);
    EXPECT_NEAR(at({0, 1, 2}, {3, 5, 7}), lowAt({3, 13, 23}), quantisation);
    EXPECT_NEAR(at({8, 0, 4}, {5, 0, 0}), lowAt({69, 0, 32}) + 8.0, quantisation);
    // The first residual is also a corner of cells of the bricks before it; it is in their last samples.
    EXPECT_NEAR(at({0, 0, 2}, {0, 8, 0}), std::max(lowAt({0, 8, 16}) - 24.0, -10.0), quantisation);
    EXPECT_NEAR(at({0, 0, 1}, {0, 8, 8}), std::max(lowAt({0, 8, 16}) - 24.0, -10.0), quantisation);
    EXPECT_EQ(bricks.corrected(), 6U);  // two with residuals, three before the first, one before the second
}

TEST(HybridLoadOfAJob, PointsOfThresholdZeroAreTheSourceToTheirEightBits) {
    const test::TempDir dir;
    const auto volume = test::sample(45, 38, 41, prep::ScalarType::i16);
    test::make({volume}, test::jobOf(0.0, 12, "points"), dir / "a.mote");
    const auto manifest = storage::readManifest(dir / "a.mote").value();
    const auto step = loadHybrid(dir / "a.mote", manifest, 0, points).value();
    const auto& bricks = *step->bricks;
    const double halfStep = 0.5 * (step->range.high - step->range.low) / 255.0;
    test::eachSample({45, 38, 41}, [&](const storage::GridSize& at) {
        const glm::uvec3 sample(at[0], at[1], at[2]);
        const auto code = Placed{bricks, sample / 8U, sample % 8U}.code();
        EXPECT_NEAR(step->valueOf(code), volume.at(at[0], at[1], at[2]), halfStep + test::slack(volume));
    });
}

TEST_F(HybridLoad, SaysWhatThereIsNot) {
    EXPECT_EQ(loadHybrid(dir_ / "a.mote", manifest_, 1, volume).error().where, "step");
    auto bare = manifest_.hybrid();
    EXPECT_EQ(*hybridParts(bare, best), residual);
    bare.set_residual(false);
    EXPECT_EQ(*hybridParts(bare, best), points);
    bare.set_point_bytes(0);
    EXPECT_EQ(*hybridParts(bare, best), volume);
    EXPECT_EQ(hybridParts(bare, points).error().where, "hybrid.representation");
    EXPECT_EQ(hybridParts(bare, residual).error().code, ErrorCode::unsupported);
}

}  // namespace
}  // namespace mote::render

namespace mote::prep {
namespace {

// What other tools read of a hybrid volume that was exported, against what was put into it.

openvdb::FloatGrid::Ptr read(const std::filesystem::path& path, const char* name) {
    openvdb::initialize();
    openvdb::io::File file(path.string());
    file.open(false);
    return openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid(name));
}

TEST(ExportHybrid, OtherToolsReadVolumeAndResidual) {
    for (const int bits : {8, 16}) {
        const test::TempDir dir;
        auto manifest = test::smallManifest(5, bits);
        manifest.mutable_hybrid()->set_index_to_world(3, 100.0);  // moved along x
        test::writeSmallHybrid(dir / "a.mote", test::smallPoints(5), manifest);
        const auto made = exportVdb(dir / "a.mote", *storage::readManifest(dir / "a.mote"), 0, dir / "a.vdb");
        ASSERT_TRUE(made.ok()) << made.error().toString();

        // 4 x 3 x 2 samples with the codes 3, 4, 5 and so on; the source has 140 x 80 x 66.
        const auto volume = read(dir / "a.vdb", "volume");
        ASSERT_TRUE(volume);
        EXPECT_EQ(volume->activeVoxelCount(), 24U);
        const double step = 255.0 / (bits == 8 ? 255 : 65535);
        EXPECT_FLOAT_EQ(volume->tree().getValue({0, 0, 0}), static_cast<float>(-10.0 + 3 * step));
        EXPECT_FLOAT_EQ(volume->tree().getValue({1, 2, 1}), static_cast<float>(-10.0 + (3 + 21) * step));
        // Centres of cells of 35 samples, counted from the centre of the first sample.
        EXPECT_TRUE(volume->indexToWorld(openvdb::Vec3d(1, 0, 0))
                        .eq({100.0 + 1.5 * 35 - 0.5, 80.0 / 6 - 0.5, 66.0 / 4 - 0.5}, 1e-12));

        // The bricks of small_hybrid.cpp, in steps of 8; samples of the error grid are 2 apart.
        const auto residual = read(dir / "a.vdb", "residual");
        ASSERT_TRUE(residual);
        EXPECT_EQ(residual->activeVoxelCount(), 3U);
        EXPECT_EQ(residual->tree().getValue({2, 13, 23}), 136.0F);
        EXPECT_EQ(residual->tree().getValue({69, 0, 32}), 8.0F);
        EXPECT_TRUE(residual->indexToWorld(openvdb::Vec3d(69, 0, 32)).eq({100.0 + 138.5, 0.5, 64.5}, 1e-12));
    }
}

TEST(ExportHybrid, StepsThatAreNotThereAndDamageAreSaid) {
    const test::TempDir dir;
    test::writeSmallHybrid(dir / "a.mote", test::smallPoints(5), test::smallManifest(5, 8));
    const auto manifest = *storage::readManifest(dir / "a.mote");
    const auto none = exportVdb(dir / "a.mote", manifest, 1, dir / "a.vdb");
    ASSERT_FALSE(none.ok());
    EXPECT_EQ(none.error().code, ErrorCode::invalidArgument);
    std::filesystem::resize_file(dir / "a.mote/residual-000000.vdb", 300);
    const auto cut = exportVdb(dir / "a.mote", manifest, 0, dir / "a.vdb");
    ASSERT_FALSE(cut.ok());
    EXPECT_THAT(cut.error().where, testing::HasSubstr("residual-000000.vdb"));
    EXPECT_FALSE(std::filesystem::exists(dir / "a.vdb"));
}

}  // namespace
}  // namespace mote::prep
