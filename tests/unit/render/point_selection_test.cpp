// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/point_selection.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "protocol/scene/drawn_points.h"
#include "protocol/scene/particles_style.h"
#include "server/render/plan/octree_cell.h"
#include "server/render/plan/selection_cache.h"
#include "tests/support/beams.h"
#include "tests/support/memory_step.h"

namespace mote::render {
namespace {

using test::MemoryStep;

Curve curve(std::vector<Curve::Knot> knots) {
    return Curve::create(std::move(knots)).value();
}

Frustum everything(double halfHeight = 100.0) {
    Camera camera;
    camera.orthographicHeight = 2.0 * halfHeight;
    return Frustum(camera, 100, 100, 0.0, 0.0, camera.worldToEye());
}

std::shared_ptr<const MemoryStep> beamStep() {
    return MemoryStep::make(test::beam({.core = 8000, .halo = 2000, .filaments = 1000}),
                            {.leafCapacity = 16});
}

/// The definition, leaf by leaf, without shortcuts or order.
std::vector<std::uint32_t> byDefinition(const storage::ParticleStep& step, const Curve& fraction,
                                        double share) {
    const auto leaves = step.leaves();
    const auto nodes = step.nodes();
    std::vector<std::uint32_t> drawn;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const auto node = leaves.node[i];
        const double wanted = share * fraction(step.logDensity().ofLeaf(leaves.density[i]));
        drawn.push_back(drawnPoints(wanted, leaves.pointCount[i], nodes.level[node], nodes.morton[node]));
    }
    return drawn;
}

std::vector<bool> inViewByDefinition(const storage::ParticleStep& step, const Frustum& frustum) {
    std::vector<bool> result;
    const auto nodes = step.nodes();
    for (const auto node : step.leaves().node) {
        const double half = std::ldexp(1.0, -nodes.level[node]);
        const glm::dvec3 center = -1.0 + 2.0 * half * (glm::dvec3(cellPlace(nodes.morton[node])) + 0.5);
        result.push_back(frustum.of(center, half) != Frustum::Side::outside);
    }
    return result;
}

std::vector<Curve> curves() {
    return {Curve::constant(1.0),
            Curve::constant(0.0),
            Curve::constant(0.3),
            curve({{0.3, 1.0}, {0.7, 0.0}}),
            curve({{0.3, 0.0}, {0.7, 1.0}}),
            curve({{0.5, 1.0}, {0.5, 0.0}}),
            curve({{0.0, 0.0}, {0.5, 1.0}, {1.0, 0.0}})};
}

TEST(ZeroFrom, FindsWhereACurveEndsInZero) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    EXPECT_EQ(zeroFrom(Curve::constant(1.0)), infinite);
    EXPECT_EQ(zeroFrom(Curve::constant(0.0)), 0.0);
    EXPECT_EQ(zeroFrom(curve({{0.2, 1.0}, {0.6, 0.0}})), 0.6);
    EXPECT_EQ(zeroFrom(curve({{0.2, 1.0}, {0.6, 0.0}, {0.8, 0.0}, {1.0, 0.0}})), 0.6);
    EXPECT_EQ(zeroFrom(curve({{0.2, 1.0}, {0.6, 0.0}, {0.8, 0.5}, {0.9, 0.0}})), 0.9);
    EXPECT_EQ(zeroFrom(curve({{0.0, 0.0}, {1.0, 0.1}})), infinite);
    EXPECT_EQ(zeroFrom(curve({{0.5, 1.0}, {0.5, 0.0}})), 0.5);
}

TEST(SelectPoints, IsTheDefinitionWhateverTheCurve) {
    const auto step = beamStep();
    for (const auto& fraction : curves()) {
        for (const double share : {1.0, 0.4}) {
            auto selection = selectPoints(*step, {.fraction = fraction, .share = share});
            EXPECT_EQ(selection.points, std::accumulate(selection.drawn.begin(), selection.drawn.end(), 0U));
            selection.drawn.resize(step->leaves().size(), 0);
            EXPECT_EQ(selection.drawn, byDefinition(*step, fraction, share));
        }
    }
}

TEST(SelectPoints, DoesNotLookBeyondTheLastLeafThatIsDrawn) {
    const auto step = beamStep();
    const auto selection = selectPoints(*step, {.fraction = curve({{0.3, 1.0}, {0.7, 0.0}})});
    const double last = step->logDensity().ofLeaf(step->leaves().density[selection.drawn.size() - 1]);
    EXPECT_LE(last, 0.7 + 1e-6);
    EXPECT_LT(selection.drawn.size(), step->leaves().size());
}

TEST(LeavesInView, AreThoseThatTouchTheFrustum) {
    const auto step = beamStep();
    Camera inside;
    inside.eye = {0.1, 0.05, 0.2};
    inside.target = {0.4, 0.1, -0.3};
    const Frustum narrow(inside, 160, 90, 0.5, 1e-3, inside.worldToEye());
    const auto expected = inViewByDefinition(*step, narrow);
    for (const auto& fraction : curves()) {
        const auto bits = leavesInView(*step, narrow, {.fraction = fraction});
        const auto drawn = selectPoints(*step, {.fraction = fraction}).drawn;
        ASSERT_EQ(bits.size(), (expected.size() + 63) / 64);
        for (std::size_t i = 0; i < drawn.size(); ++i) {
            EXPECT_TRUE(drawn[i] == 0 || inView(bits, i) == expected[i]) << i;
        }
    }
}

TEST(LeavesInView, OfAPlotThatIsWhollyInViewNeedNoBits) {
    EXPECT_TRUE(leavesInView(*beamStep(), everything(), {}).empty());
    EXPECT_TRUE(inView({}, 12345));
}

TEST(SelectPoints, AnEmptyStepDrawsNothing) {
    const auto step = MemoryStep::make({});
    EXPECT_TRUE(selectPoints(*step, {}).drawn.empty());
}

TEST(SelectPoints, OneDensityIsTheLeast) {
    const auto step = MemoryStep::make({{{0.2, 0.3, 0.4}}});
    EXPECT_EQ(selectPoints(*step, {.fraction = curve({{0.0, 1.0}, {0.1, 0.0}})}).points, 1U);
    EXPECT_EQ(selectPoints(*step, {.fraction = curve({{0.0, 0.0}, {0.1, 1.0}})}).points, 0U);
}

/// What a camera that moves needs is told once, and told anew for another step, curve or volume.
TEST(SelectionCache, NeedsWhatTheChoiceNeeds) {
    SelectionCache cache;
    const std::array steps{beamStep(), MemoryStep::make(test::evenCloud(20000, 3), {.leafCapacity = 16})};
    const auto all = curve({{0.0, 1.0}, {1.0, 1.0}}), few = curve({{0.0, 1.0}, {0.3, 1.0}, {0.3, 0.0}});
    std::vector<std::shared_ptr<const StepVolume>> volumes{nullptr};
    for (const double from : {0.0, 0.6}) {
        const auto transfer =
            ParticlesStyle::transferOf(curve({{from, 0.0}, {from, 0.3}}), ColorMap::standard());
        volumes.push_back(std::make_shared<const StepVolume>(stepVolume(*steps[0], transfer, few)));
    }
    for (int again = 0; again < 2; ++again) {
        for (const auto& step : steps) {
            for (const auto& fraction : {all, few}) {
                for (const auto& volume : volumes) {
                    if (volume != nullptr && step != steps[0]) continue;
                    const PointChoice choice{
                        .fraction = fraction, .share = 0.5 / (1 + again), .volume = volume};
                    const auto wanted = neededPoints(*step, choice), got = cache.needed(step, choice);
                    ASSERT_EQ(got.size(), wanted.size());
                    for (std::size_t i = 0; i < got.size(); ++i) {
                        EXPECT_EQ(got[i].begin, wanted[i].begin);
                        EXPECT_EQ(got[i].count, wanted[i].count);
                    }
                }
            }
        }
    }
}

}  // namespace
}  // namespace mote::render
