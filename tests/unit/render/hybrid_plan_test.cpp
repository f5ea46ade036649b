// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/hybrid/hybrid_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "server/render/hybrid/point_looks.h"
#include "tests/support/hybrid_scene.h"

namespace mote::render {
namespace {

HybridPlan planOf(const std::shared_ptr<const HybridStep>& step, std::uint32_t stride) {
    HybridStyle style;
    style.representation = HybridRepresentation::points;
    return planHybrid(style, glm::dmat4(1.0), step, fitCamera(step->bounds(), 1.0), stride);
}

std::shared_ptr<const HybridStep> machine() {
    return test::hybridOf({.threshold = 0.02}, test::machineParts);
}

TEST(HybridPlan, OfEachRunOfPointsOneIsDrawn) {
    const auto step = machine();
    const auto points = static_cast<std::uint32_t>(step->points->points.size());
    ASSERT_GT(points, 1000U);
    for (const std::uint32_t stride : {1U, 2U, 3U, 10U, 99U, 100000U}) {
        const auto plan = planOf(step, stride);
        ASSERT_EQ(plan.pointCount(), (points + plan.pointStride - 1) / plan.pointStride);
        for (std::uint32_t i = 0; i < plan.pointCount(); ++i) {
            ASSERT_EQ(plan.point(i) / plan.pointStride, i);
            ASSERT_LT(plan.point(i), points);
        }
    }
}

TEST(HybridPlan, FewerPointsStandForAllOfThem) {
    const auto step = machine();
    for (const std::uint32_t stride : {1U, 2U, 4U, 10U, 100U}) {
        const auto plan = planOf(step, stride);
        EXPECT_NEAR(plan.pointGrowth() * plan.pointGrowth() * plan.pointStrength(), plan.pointStride, 1e-9);
        EXPECT_LE(plan.pointGrowth(), 3.0);
    }
}

TEST(KeptPointLooks, FollowWhatTheyAreMadeOf) {
    const auto step = machine(), other = machine();
    const auto all = planOf(step, 1), few = planOf(step, 100);
    KeptPointLooks kept;
    const PointLooks first = kept.of(all);
    const auto& point =
        *std::max_element(step->points->points.begin(), step->points->points.end(),
                          [&](const auto& a, const auto& b) { return first.opacity(a) < first.opacity(b); });
    const float whole = kept.of(all).opacity(point);
    ASSERT_GT(whole, 0.0F);
    ASSERT_LT(whole, 0.9F);
    // A hundred cells in nine: the optical depth of a ninth of a hundred.
    EXPECT_NEAR(kept.of(few).opacity(point), 1.0 - std::pow(1.0 - whole, 100.0 / 9.0), 1e-4);
    auto faint = all;
    HybridStyle style = all.style;
    style.opacity = Curve::constant(0.001);
    faint.transfer = HybridTransfer(style, *step);
    EXPECT_LT(kept.of(faint).opacity(point), whole);
    EXPECT_EQ(kept.of(all).opacity(point), whole);
    EXPECT_EQ(kept.of(planOf(other, 1)).opacity(point), whole);
}

}  // namespace
}  // namespace mote::render
