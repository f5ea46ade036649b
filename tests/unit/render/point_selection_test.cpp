// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/point_selection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "protocol/scene/drawn_points.h"
#include "server/render/octree_cell.h"
#include "storage/storage_error.h"
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

/// The definition, leaf by leaf, without octree, shortcuts or order.
std::vector<std::uint32_t> byDefinition(const storage::ParticleStep& step, const Frustum& frustum,
                                        const Curve& fraction, double share) {
    const auto leaves = step.leaves();
    const auto nodes = step.nodes();
    std::vector<std::uint32_t> drawn;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const auto node = leaves.node[i];
        const double half = std::ldexp(1.0, -nodes.level[node]);
        const glm::dvec3 center = -1.0 + 2.0 * half * (glm::dvec3(cellPlace(nodes.morton[node])) + 0.5);
        const bool out = frustum.of(center, half) == Frustum::Side::outside;
        const double wanted = share * fraction(step.logDensity().ofLeaf(leaves.density[i]));
        drawn.push_back(
            out ? 0 : drawnPoints(wanted, leaves.pointCount[i], nodes.level[node], nodes.morton[node]));
    }
    return drawn;
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

TEST(SelectPoints, IsTheDefinitionWhateverTheCurveAndTheView) {
    const auto step = beamStep();
    const Curve curves[] = {Curve::constant(1.0),
                            Curve::constant(0.0),
                            Curve::constant(0.3),
                            curve({{0.3, 1.0}, {0.7, 0.0}}),
                            curve({{0.3, 0.0}, {0.7, 1.0}}),
                            curve({{0.5, 1.0}, {0.5, 0.0}}),
                            curve({{0.0, 0.0}, {0.5, 1.0}, {1.0, 0.0}})};
    Camera inside;
    inside.eye = {0.1, 0.05, 0.2};
    inside.target = {0.4, 0.1, -0.3};
    const Frustum narrow(inside, 160, 90, 0.5, 1e-3, inside.worldToEye());
    for (const auto& fraction : curves) {
        for (const double share : {1.0, 0.4}) {
            EXPECT_EQ(selectPoints(*step, everything(), fraction, share),
                      byDefinition(*step, everything(), fraction, share));
            EXPECT_EQ(selectPoints(*step, narrow, fraction, share),
                      byDefinition(*step, narrow, fraction, share));
        }
    }
}

TEST(SelectPoints, AnEmptyStepDrawsNothing) {
    const auto step = MemoryStep::make({});
    EXPECT_TRUE(selectPoints(*step, everything(), Curve::constant(1.0), 1.0).empty());
}

TEST(SelectPoints, OneDensityIsTheLeast) {
    const auto step = MemoryStep::make({{{0.2, 0.3, 0.4}}});
    EXPECT_EQ(selectPoints(*step, everything(), curve({{0.0, 1.0}, {0.1, 0.0}}), 1.0),
              std::vector<std::uint32_t>{1});
    EXPECT_EQ(selectPoints(*step, everything(), curve({{0.0, 0.0}, {0.1, 1.0}}), 1.0),
              std::vector<std::uint32_t>{0});
}

/// A step of which one array of the octree says something else.
class Altered final : public storage::ParticleStep {
  public:
    explicit Altered(std::shared_ptr<const MemoryStep> step) : step_(std::move(step)) {
        const auto nodes = step_->nodes();
        firstChild.assign(nodes.firstChild.begin(), nodes.firstChild.end());
        level.assign(nodes.level.begin(), nodes.level.end());
        const auto leaves = step_->leaves();
        node.assign(leaves.node.begin(), leaves.node.end());
    }
    storage::OctreeNodes nodes() const override {
        auto nodes = step_->nodes();
        nodes.firstChild = firstChild;
        nodes.level = level;
        return nodes;
    }
    storage::Leaves leaves() const override {
        auto leaves = step_->leaves();
        leaves.node = node;
        return leaves;
    }
    std::uint64_t pointCount() const override { return step_->pointCount(); }
    std::span<const storage::PackedPosition> positions(std::uint64_t begin,
                                                       std::uint64_t count) const override {
        return step_->positions(begin, count);
    }
    std::span<const std::uint64_t> rows(std::uint64_t begin, std::uint64_t count) const override {
        return step_->rows(begin, count);
    }
    std::span<const float> volume() const override { return step_->volume(); }
    std::uint32_t volumeSize() const override { return step_->volumeSize(); }
    LogDensity logDensity() const override { return step_->logDensity(); }

    std::vector<std::uint32_t> firstChild, node;
    std::vector<std::uint8_t> level;

  private:
    std::shared_ptr<const MemoryStep> step_;
};

void expectDamaged(const Altered& step) {
    // Part of the box out of view, so that the octree is walked.
    EXPECT_THROW(selectPoints(step, everything(0.9), Curve::constant(0.5), 1.0), storage::StorageError);
}

TEST(SelectPoints, RefusesAnOctreeThatContradictsItself) {
    const Altered sound(beamStep());
    EXPECT_NO_THROW(selectPoints(sound, everything(0.9), Curve::constant(0.5), 1.0));
    auto damaged = sound;
    damaged.firstChild[0] = static_cast<std::uint32_t>(damaged.firstChild.size());
    expectDamaged(damaged);
    damaged = sound;
    damaged.firstChild[0] = 0;  // a circle
    expectDamaged(damaged);
    damaged = sound;
    damaged.firstChild.back() = 4'000'000'000U;  // a leaf that is not there
    expectDamaged(damaged);
    damaged = sound;
    damaged.level[1] = 200;
    expectDamaged(damaged);
    damaged = sound;
    damaged.node[0] = 4'000'000'000U;
    expectDamaged(damaged);
}

}  // namespace
}  // namespace mote::render
