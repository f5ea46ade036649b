// SPDX-License-Identifier: GPL-3.0-or-later
//
// What rays through scalar fields are made of: samples as the field is drawn, extinction between them, and
// the rims of surfaces.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "server/render/layers/ink/extinction_table.h"
#include "server/render/layers/ink/volume_lines.h"
#include "server/render/layers/ink/volume_samples.h"
#include "tests/support/hybrid_scene.h"
#include "tests/support/random.h"

namespace mote::render {
namespace {

/// Bricks that correct everything hold the source's samples; between them values are trilinear.
TEST(VolumeSamples, AreTheSourcesInBricksAndTheCoarseGridsElsewhere) {
    const test::HybridShape shape{.source = {24, 20, 17}, .low = {6, 5, 4}, .threshold = 0.02};
    const auto field = test::hybridOf(shape, test::machineParts);
    ASSERT_NE(field->bricks, nullptr);
    const VolumeSamples samples(*field);
    EXPECT_EQ(samples.cells(), glm::dvec3(24.0, 20.0, 17.0));
    std::size_t corrected = 0;
    for (std::uint32_t z = 0; z < 17; ++z) {
        for (std::uint32_t y = 0; y < 20; ++y) {
            for (std::uint32_t x = 0; x < 24; ++x) {
                const glm::dvec3 middle = glm::dvec3(x, y, z) + 0.5;
                const double value = field->valueOf(static_cast<double>(samples.code(glm::vec3(middle))));
                const double source = std::clamp(test::machineParts(middle / samples.cells()), 0.0, 1.0);
                // What is not corrected is within the threshold; codes are a 65535th.
                EXPECT_NEAR(value, source, shape.threshold + 2e-5);
                corrected += std::abs(value - source) < 2e-5 ? 1 : 0;
            }
        }
    }
    EXPECT_GT(corrected, 1000U);
    // Beyond the outermost samples the nearest holds.
    EXPECT_EQ(samples.code({0.0F, 7.5F, 3.5F}), samples.code({0.5F, 7.5F, 3.5F}));
    EXPECT_EQ(samples.code({5.5F, 20.0F, 3.5F}), samples.code({5.5F, 19.5F, 3.5F}));
}

TEST(VolumeSamples, HaveTheSlopeOfARamp) {
    const test::HybridShape shape{.source = glm::uvec3(16), .low = glm::uvec3(16)};
    const auto field =
        test::hybridOf(shape, [](const auto& at) { return 0.1 + 0.5 * at.x + 0.25 * at.y - 0.05 * at.z; });
    const auto slope = glm::dvec3(VolumeSamples(*field).slope({8.3F, 7.1F, 4.9F})) * 16.0 / 65535.0;
    EXPECT_NEAR(slope.x, 0.5, 1e-3);
    EXPECT_NEAR(slope.y, 0.25, 1e-3);
    EXPECT_NEAR(slope.z, -0.05, 1e-3);
}

TEST(ExtinctionTable, HoldsTheMeanBetweenTwoValues) {
    test::Random random(3);
    const test::HybridShape shape{.source = glm::uvec3(2), .low = glm::uvec3(2), .range = {-5.0, 3.0}};
    const auto field = test::hybridOf(shape, [](const auto&) { return 0.0; });
    const TransferFunction transfer{
        .opacity = Curve::create({{-2.0, 0.0}, {-1.0, 0.3}, {0.0, 0.1}, {2.0, 0.9}}, -10.0, 10.0).value(),
        .opacityLength = 0.5,
        .span = {-3.0, 2.5}};
    const ExtinctionTable table(*field, TransferTable(transfer));
    for (int i = 0; i < 200; ++i) {
        const double from = random.between(-5.0, 3.0), to = from + random.sign() * random.magnitude(-12, 2);
        double mean = 0.0;
        constexpr int parts = 4000;
        for (int k = 0; k < parts; ++k)
            mean += transfer.extinction(std::lerp(from, to, (k + 0.5) / parts)) / parts;
        const double told = table.mean(table.at(static_cast<float>(field->codeOf(from))),
                                       table.at(static_cast<float>(field->codeOf(to))));
        // A cell of the table is 5.5 / 4095 wide, where extinction changes by at most 12 a unit.
        EXPECT_NEAR(told, mean, 0.02) << from << ' ' << to;
    }
    const auto below = table.at(static_cast<float>(field->codeOf(-4.0)));
    EXPECT_EQ(table.mean(below, below + 1.0), 0.0);
}

TEST(Rims, AreTheSteepBordersOfSurfaces) {
    Raster<float> sharp(64, 3), gentle(64, 3);
    for (std::uint32_t y = 0; y < 3; ++y) {
        for (std::uint32_t x = 0; x < 64; ++x) {
            sharp.at(x, y) = static_cast<float>(std::clamp(1.0 - (x - 4.2) / 6.0, 0.0, 1.0));
            gentle.at(x, y) = static_cast<float>(std::max(0.6 - 0.01 * x, 0.0));
        }
    }
    const auto rims = rimsOf(sharp), none = rimsOf(gentle);
    for (std::uint32_t x = 0; x < 64; ++x) {
        // It falls by a sixth a pixel, from one half on at 7; from 20 pixels on all is far away.
        EXPECT_EQ(rims.at(x, 1), x > 7 && x < 27 ? 1 : 0) << x;
        EXPECT_EQ(none.at(x, 1), 0) << x << ": a hundredth a pixel";
    }
    EXPECT_EQ(rimsOf(Raster<float>(3, 2, 0.4F)), Raster<std::uint8_t>(3, 2)) << "beside no surface";
}

}  // namespace
}  // namespace mote::render
