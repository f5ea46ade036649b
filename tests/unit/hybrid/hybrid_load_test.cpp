// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/hybrid/hybrid_load.h"

#include <gtest/gtest.h>

#include "storage/hybrid/grid_axis.h"
#include "storage/manifest.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/hybrid/small_hybrid.h"

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
    std::shared_ptr<const HybridStep> load(HybridRepresentation representation) {
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
    EXPECT_FALSE(low->bricks || low->points);
    EXPECT_EQ(low->low.size, glm::uvec3(4, 3, 2));
    EXPECT_NEAR(low->valueOf(low->low.values[23]), 16.0, 255.0 / 65535.0);
    EXPECT_EQ(low->low.normals[1], 4);
    EXPECT_TRUE(load(points)->points);
    EXPECT_FALSE(load(points)->bricks);
    EXPECT_TRUE(load(residual)->bricks);
}

TEST_F(HybridLoad, TheBoxIsWhereTheVoxelsAre) {
    const auto step = load(volume);
    EXPECT_EQ(step->bounds(), (Bounds{glm::dvec3(-0.5), glm::dvec3(139.5, 79.5, 65.5)}));
    EXPECT_EQ(step->longestEdge(), 140.0);
}

TEST_F(HybridLoad, PointsKeepTheirPlacesAndCodes) {
    const auto step = load(points);
    EXPECT_EQ(step->points->size, glm::uvec3(70, 40, 33));
    EXPECT_EQ(step->points->errorStep, 2.0);
    ASSERT_EQ(step->points->points.size(), 5U);
    const auto& point = step->points->points[3];
    EXPECT_EQ(glm::uvec3(point.x, point.y, point.z), glm::uvec3(32, 39, 5));
    EXPECT_EQ(point.value, 150);
    EXPECT_EQ(point.error, 181);
    EXPECT_EQ(point.normal, 3);
}

TEST_F(HybridLoad, BricksAreTheLowVolumeWithWhatIsAdded) {
    const auto step = load(residual);
    const auto& bricks = *step->bricks;
    EXPECT_EQ(bricks.count, glm::uvec3(9, 5, 5));
    const auto at = [&](const glm::uvec3& brick, const glm::uvec3& sample) {
        const auto number = bricks.numbers[bricks.index(brick)];
        EXPECT_NE(number, HybridBricks::none);
        return step->valueOf(bricks.values[static_cast<std::size_t>(number) * HybridBricks::volume +
                                           (sample.z * 9 + sample.y) * 9 + sample.x]);
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
