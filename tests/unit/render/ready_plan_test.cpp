// SPDX-License-Identifier: GPL-3.0-or-later
//
// Plans of steps that are not in memory: nothing is touched that would make the picture wait.
#include <gtest/gtest.h>

#include <cmath>

#include "server/render/layers/make_frame_plan.h"
#include "tests/support/generated_mesh.h"
#include "tests/support/view_text.h"

namespace mote::render {
namespace {

/// A large step of which a preview and the volume are there, and nothing else.
class DistantStep final : public storage::ParticleStep {
  public:
    explicit DistantStep(std::uint64_t previewReady) : ready_(previewReady), points_(shown) {
        for (std::size_t block = 0; block < shown / storage::Preview::blockPoints; ++block) {
            threshold_.push_back(static_cast<float>(block + 1) * 1e-4F);
        }
    }

    storage::OctreeNodes nodes() const override { return unexpected<storage::OctreeNodes>(); }
    storage::Leaves leaves() const override { return unexpected<storage::Leaves>(); }
    std::uint64_t pointCount() const override { return 8 * shown; }
    std::span<const storage::PackedPosition> positions(std::uint64_t, std::uint64_t) const override {
        return unexpected<std::span<const storage::PackedPosition>>();
    }
    std::span<const std::uint64_t> rows(std::uint64_t, std::uint64_t) const override { return {}; }
    std::span<const float> volume() const override { return volume_; }
    std::uint32_t volumeSize() const override { return 1; }
    storage::Preview preview(std::uint64_t most) const override {
        return {std::span(points_).first(std::min<std::size_t>(most, shown)), shown, threshold_,
                logDensity()};
    }
    LogDensity logDensity() const override { return {1.0, 100.0}; }
    bool octreeReady() const override { return false; }
    std::uint64_t previewReady(std::uint64_t) const override { return ready_; }

  private:
    static constexpr std::size_t shown = std::size_t{1} << 21;

    template <class T>
    static T unexpected() {
        ADD_FAILURE() << "the picture would wait";
        return {};
    }

    std::uint64_t ready_;
    std::vector<storage::PreviewPoint> points_;
    std::vector<float> threshold_;
    std::vector<float> volume_{1.0F};
};

FramePlan planOf(std::uint64_t previewReady, double share, const char* layer,
                 std::shared_ptr<const MeshSurface> mesh = nullptr) {
    Scene scene{test::viewOf(std::string("{'width': 200, 'height': 100, 'camera': {'eye': [0, 0, 4], "
                                         "'target': [0, 0, 0]}, 'layers': [") +
                             layer + "]}"),
                {}};
    if (mesh) scene.layers.push_back({.mesh = std::move(mesh)});
    scene.layers.push_back({.step = std::make_shared<DistantStep>(previewReady)});
    SelectionCache selections;
    return makeFramePlan(scene, {.pointFraction = share}, selections, {.preview = true},
                         Reading::notForPoints);
}

TEST(ReadyPlan, PointsThatAreNotThereComeFromThePreview) {
    const auto plan = planOf(0, 1.0, "{'particles': {}}");
    const auto& layer = plan.points.at(0);
    EXPECT_TRUE(plan.waits());
    EXPECT_TRUE(layer.waits);
    ASSERT_NE(layer.preview, nullptr);
    EXPECT_TRUE(layer.selection->drawn.empty());
    EXPECT_GT(layer.share, 0.0);
    EXPECT_LT(layer.share, 1.0);
    EXPECT_TRUE(layer.need.octree);
    EXPECT_TRUE(layer.need.volume);
    EXPECT_GT(layer.need.preview, 0U);
    EXPECT_TRUE(layer.need.points.empty()) << "which they are, the octree will tell";
}

TEST(ReadyPlan, TheShareGrowsWithWhatIsReadyAndStopsAtWhatWasAskedFor) {
    const auto little = planOf(0, 1.0, "{'particles': {}}");
    const auto more = planOf(std::uint64_t{1} << 21, 1.0, "{'particles': {}}");
    EXPECT_LE(little.points[0].preview->points, std::uint64_t{1} << 20);
    EXPECT_GT(more.points[0].share, little.points[0].share);
    EXPECT_LE(more.points[0].preview->points, std::uint64_t{1} << 21);
    // So few points that what is read on the spot has them: nothing is missing.
    const auto enough = planOf(0, 1e-3, "{'particles': {}}");
    EXPECT_EQ(enough.points[0].share, 1e-3);
    EXPECT_FALSE(enough.waits());
}

TEST(ReadyPlan, ASurfaceIsNotLookedForWhereThePictureWaits) {
    const char* layers = "{'mesh': {}}, {'particles': {}}";
    const auto mesh = test::meshOf("sphere", 0, 0);
    EXPECT_TRUE(planOf(0, 1.0, layers, mesh).surfaces.empty());
    EXPECT_EQ(planOf(0, 1e-3, layers, mesh).surfaces.size(), 1U) << "nothing is missing";
    EXPECT_EQ(planOf(0, 0.5, layers, mesh).surfaces.size(), 1U) << "a picture in motion is drawn as it is";
}

TEST(ReadyPlan, OpacityMakesUpForTheShare) {
    const auto few = planOf(0, 1.0, "{'particles': {'points': {'opacity': 0.001}}}");
    const auto& layer = few.points[0];
    // Of n points of opacity a, each drawn by a chance of s, (1 - s b)^n is left on average: b = a / s.
    EXPECT_NEAR(layer.look.opacity, 0.001 / layer.share, 1e-12);
}

}  // namespace
}  // namespace mote::render
