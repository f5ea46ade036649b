// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/calibration.h"

#include <gtest/gtest.h>

#include <chrono>
#include <numeric>

#include "storage/particles/octree_check.h"

namespace mote::render {
namespace {

TEST(CalibrationStep, IsASoundOctree) {
    const CalibrationStep step;
    const auto checked = storage::checkOctree(step.nodes(), step.leaves(), step.pointCount(), 4);
    EXPECT_TRUE(checked.ok()) << checked.error().toString();
    const auto counts = step.leaves().pointCount;
    EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), std::uint64_t{0}), step.pointCount());
    EXPECT_EQ(step.volume().size(), 64U * 64 * 64);
}

/// Draws nothing, and remembers what it was asked to draw.
class RecordingDevice final : public Device {
  public:
    std::string name() const override { return "recording"; }
    void trim() override {}
    std::optional<Picture> render(const FramePlan& plan, PixelFormat format, std::stop_token) override {
        points.push_back(plan.points.at(0).pointsDrawn);
        return Picture{plan.width, plan.height, format, {}, points.back()};
    }
    std::vector<std::uint64_t> points;
};

TEST(Calibration, ComparesPicturesWithPointsAndWithout) {
    RecordingDevice device;
    const DeviceCosts costs = calibrate(device);
    EXPECT_EQ(device.points.front(), 0U);
    EXPECT_GT(device.points.back(), 100000U);
    // However quick a device is, nothing is for nothing.
    EXPECT_GT(costs.millionPoints, 0.0);
    EXPECT_GT(costs.millionPixels, 0.0);
}

TEST(Calibration, AnExactPictureIsTheUnitOfWork) {
    EXPECT_EQ(pixelWork(Quality::exact()), 1.0);
    EXPECT_LT(pixelWork({.slabs = 24, .samplesPerCell = 1.0}), 0.25);
}

}  // namespace
}  // namespace mote::render
