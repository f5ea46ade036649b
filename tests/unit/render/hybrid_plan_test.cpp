// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/hybrid/hybrid_plan.h"

#include <gtest/gtest.h>

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include "server/render/cpu/resident_hybrids.h"
#include "tests/support/hybrid_scene.h"

namespace mote::render {
namespace {

using enum HybridRepresentation;

std::shared_ptr<const HybridStep> machine(HybridRepresentation parts) {
    return test::hybridOf({.threshold = 0.1, .parts = parts}, test::machineParts);
}

HybridPlan planOf(const std::shared_ptr<const HybridStep>& step, HybridRepresentation representation,
                  double opacity = 1.0, PointShape shape = PointShape::square) {
    HybridStyle style;
    style.representation = representation;
    style.pointOpacity = opacity;
    style.pointShape = shape;
    return planHybrid(style, glm::dmat4(1.0), step, fitCamera(step->bounds(), 1.0));
}

TEST(HybridPlan, PointsCorrectAsMuchAsTheirStyleSays) {
    const auto step = machine(points);
    EXPECT_EQ(planOf(step, best).representation, points);
    for (const double opacity : {0.0, 0.3, 1.0}) {
        const auto plan = planOf(step, points, opacity);
        EXPECT_EQ(plan.corrected(), opacity > 0.0);
        EXPECT_EQ(plan.mixed(), opacity == 0.3);
        EXPECT_EQ(plan.correction(), opacity);
    }
    EXPECT_FALSE(planOf(step, volume).corrected());
    EXPECT_FALSE(planOf(machine(volume), points).corrected()) << "they may be on their way";
}

TEST(HybridPlan, AResidualKnowsNothingOfPoints) {
    const auto plan = planOf(machine(residual), residual, 0.3);
    EXPECT_TRUE(plan.corrected());
    EXPECT_FALSE(plan.mixed());
    EXPECT_EQ(plan.steepness(), 1.0);
}

TEST(HybridPlan, ShapesAreAsSteepAsPictureSays) {
    const auto step = machine(points);
    EXPECT_EQ(planOf(step, points, 1.0, PointShape::gaussian).steepness(), 1.0);
    EXPECT_EQ(planOf(step, points, 1.0, PointShape::disc).steepness(), 2.0);
    EXPECT_EQ(planOf(step, points, 1.0, PointShape::square).steepness(), 8.0);
}

TEST(HybridRanges, HoldWhatShowsOfTheLowVolumeInBricks) {
    const auto step = machine(points);
    const auto whole = hybridRanges(*step, true, false).ranges(),
               low = hybridRanges(*step, false, false).ranges();
    const auto mixed = hybridRanges(*step, true, true).ranges();
    const auto& count = step->bricks->count;
    ASSERT_EQ(low.size(), 1U);  // 8 x 8 x 8 samples
    bool wider = false;
    for (std::size_t i = 0; i < whole.size(); ++i) {
        EXPECT_LE(mixed[i].low, whole[i].low);
        EXPECT_GE(mixed[i].high, whole[i].high);
        EXPECT_TRUE(mixed[i].low == whole[i].low || mixed[i].low >= low[0].low);
        EXPECT_TRUE(mixed[i].high == whole[i].high || mixed[i].high <= low[0].high);
        wider = wider || mixed[i].low < whole[i].low || mixed[i].high > whole[i].high;
        const glm::uvec3 brick(i % count.x, i / count.x % count.y, i / count.x / count.y);
        for (std::uint32_t corner = 0; corner < 8; ++corner) {
            // The low volume at the brick's corners lies within.
            const glm::uvec3 at = (brick + glm::uvec3(corner & 1U, corner >> 1 & 1U, corner >> 2)) * 2U;
            const auto value = static_cast<float>(
                step->valueOf(step->low.values[step->low.index(glm::min(at, step->low.size - 1U))]));
            if (glm::all(glm::lessThan(at, step->low.size))) {
                EXPECT_LE(mixed[i].low, value) << i;
                EXPECT_GE(mixed[i].high, value) << i;
            }
        }
    }
    EXPECT_TRUE(wider);
}

}  // namespace
}  // namespace mote::render
