// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/leaf_means.h"

#include <gtest/gtest.h>

#include <cmath>

#include "protocol/scene/particles_style.h"
#include "server/render/plan/step_volume.h"
#include "tests/support/beams.h"
#include "tests/support/memory_step.h"
#include "tests/support/volume_matter.h"

namespace mote::render {
namespace {

std::shared_ptr<const test::MemoryStep> someStep() {
    return test::MemoryStep::make(test::beam({.core = 8000, .halo = 1000, .filaments = 500}),
                                  {.leafCapacity = 32, .maxLevel = 7, .volumeLevel = 4});
}

TransferFunction shown() {
    return ParticlesStyle::transferOf(Curve::create({{0.1, 0.0}, {1.0, 0.5}}).value(), ColorMap::standard());
}

/// By point, from its leaf and its place in it.
template <class Code>
PointValues valuesOf(const test::MemoryStep& step, const Code& code) {
    PointValues values;
    const auto leaves = step.leaves();
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf)
        for (std::uint32_t i = 0; i < leaves.pointCount[leaf]; ++i) values.codes.push_back(code(leaf, i));
    return values;
}

TEST(LeafMeans, AreThoseOfThePointsThatHaveAValue) {
    const auto step = someStep();
    const auto leaves = step->leaves();
    const auto code = [](std::size_t leaf, std::uint32_t i) -> ValueCode {
        if (leaf % 5 == 0 || (leaf % 3 == 0 && i % 2 == 1)) return noValue;
        return static_cast<ValueCode>((leaf * 7919 + i * 104729) % greatestValue);
    };
    const auto means = leafMeans(*step, valuesOf(*step, code));
    ASSERT_EQ(means.codes.size(), leaves.size());
    EXPECT_TRUE(means.byLeaf);
    EXPECT_FALSE(means.complete);
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
        double sum = 0.0, count = 0.0;
        for (std::uint32_t i = 0; i < leaves.pointCount[leaf]; ++i) {
            if (code(leaf, i) == noValue) continue;
            sum += code(leaf, i);
            count += 1.0;
        }
        const double expected = count == 0.0 ? noValue : sum / count;
        EXPECT_NEAR(means.codes[leaf], expected, 0.5);
    }
}

TEST(LeafMeans, OfLeavesAreTheirOwn) {
    const auto step = someStep();
    PointValues values{.codes = std::vector<ValueCode>(step->leaves().size(), 77), .byLeaf = true};
    EXPECT_EQ(leafMeans(*step, values).codes, values.codes);
    EXPECT_TRUE(leafMeans(*step, values).complete);
}

TEST(LeafMeans, OfOneValueColorEveryCellAlike) {
    const auto step = someStep();
    const PointValues values{.codes = std::vector<ValueCode>(step->leaves().size(), 16384), .byLeaf = true};
    const auto plain = stepVolume(*step, shown(), Curve::constant(1.0)),
               colored = stepVolume(*step, shown(), Curve::constant(1.0), &values);
    EXPECT_EQ(colored.root, plain.root);
    EXPECT_EQ(colored.share, plain.share);
    std::size_t seen = 0;
    for (std::size_t cell = 0; cell < colored.t.size(); ++cell) {
        if (!(colored.root[cell] > 0.0F)) continue;
        EXPECT_NEAR(colored.t[cell], 16384.0 / greatestValue, 1e-6);
        ++seen;
    }
    EXPECT_GT(seen, 40U);
}

TEST(LeafMeans, ALeafWithoutAValueIsPointsAlone) {
    const auto step = someStep();
    PointValues values{.codes = std::vector<ValueCode>(step->leaves().size(), 60000), .byLeaf = true};
    const std::size_t last = values.codes.size() - 1;
    for (std::size_t leaf = 0; leaf <= last; leaf += 2) values.codes[last - leaf] = noValue;
    const auto plain = stepVolume(*step, shown(), Curve::constant(1.0)),
               colored = stepVolume(*step, shown(), Curve::constant(1.0), &values);
    double all = 0.0, left = 0.0;
    const auto leaves = step->leaves();
    for (std::size_t leaf = 0; leaf <= last; ++leaf) {
        const double extinction = shown().extinction(step->logDensity().ofLeaf(leaves.density[leaf])) *
                                  std::ldexp(1.0, -3 * step->nodes().level[leaves.node[leaf]]);
        if (!(extinction > 0.0)) continue;
        const bool none = values.codes[leaf] == noValue;
        EXPECT_EQ(colored.shareOf(leaf), none ? 0.0 : plain.shareOf(leaf));
        all += plain.shareOf(leaf) * extinction;
        if (!none) left += plain.shareOf(leaf) * extinction;
    }
    for (std::size_t cell = 0; cell < colored.root.size(); ++cell) {
        if (!(colored.root[cell] > 0.0F)) continue;
        EXPECT_NEAR(colored.t[cell], 60000.0 / greatestValue, 1e-6);
    }
    EXPECT_NEAR(test::matterOf(colored) / test::matterOf(plain), left / all, 0.03);
    EXPECT_LT(left / all, 0.7);
}

}  // namespace
}  // namespace mote::render
