// SPDX-License-Identifier: GPL-3.0-or-later
//
// Samples of fields as they are drawn: against the source, and those of many places against each.
#include "server/render/plan/grid/volume_samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <vector>

#include "server/render/cpu/vectors.h"
#include "server/render/plan/seen_fields.h"
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

/// As slope() has them, by code() alone.
glm::vec3 slopeOf(const VolumeSamples& samples, const glm::vec3& place, const glm::vec3& off) {
    glm::vec3 slope;
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec3 along(0.0F);
        along[axis] = off[axis];
        slope[axis] = (samples.code(place + along) - samples.code(place - along)) / (2.0F * off[axis]);
    }
    return slope;
}

/// What there is of places in a field, on its samples and beyond; by the vectors that are in use.
void expectThoseOfEach(const GridField& field, bool corrected, test::Random& random, int& fine, int& coarse) {
    const VolumeSamples samples(field, corrected);
    const glm::vec3 wide = 1.0F / glm::vec3(glm::dvec3(field.coarse.size) / samples.cells());
    std::vector<glm::vec3> asked;
    SamplePlaces places;
    for (std::uint32_t k = 0, count = 1 + random.below(SamplePlaces::most); k < count; ++k) {
        const auto unit = [&] { return random.between(-0.1, 1.1); };
        asked.push_back(samples.cells() * glm::dvec3(unit(), unit(), unit()));
        if (random.chance(0.3)) asked.back() = glm::round(2.0F * asked.back()) / 2.0F;
        places.add(asked.back());
    }
    SampleCodes codes;
    samples.codes(places, codes);
    ASSERT_EQ(places.size, asked.size());
    std::vector<glm::vec3> slopes(asked.size());
    samples.slopes(asked, slopes);
    for (std::size_t k = 0; k < asked.size(); ++k) {
        EXPECT_EQ(codes[k], samples.code(asked[k]));
        const bool near = slopes[k] == slopeOf(samples, asked[k], glm::vec3(1.0F));
        EXPECT_TRUE(near || slopes[k] == slopeOf(samples, asked[k], wide));
        ++(near ? fine : coarse);
    }
}

/// Grids of any size, corrected in some bricks, in many or not at all.
TEST(VolumeSamples, OfManyPlacesAreThoseOfEachByAnyVectors) {
    test::Random random(11);
    int fine = 0, coarse = 0;
    for (int i = 0; i < 60; ++i) {
        const test::HybridShape shape{
            .source = {1 + random.below(40), 1 + random.below(30), 1 + random.below(20)},
            .low = {1 + random.below(9), 1 + random.below(9), 1 + random.below(9)},
            .threshold = random.magnitude(-4, 0)};
        const double wave = random.magnitude(0, 2);
        const auto field = test::hybridOf(shape, [&](const glm::dvec3& at) {
            return 0.5 + 0.5 * std::sin(wave * (at.x + at.y * at.z)) * at.z;
        });
        for (const auto& name : vectorNames()) {
            SCOPED_TRACE(name);
            useVectors(*vectorsNamed(name));
            expectThoseOfEach(*field, random.chance(0.9), random, fine, coarse);
        }
    }
    useVectorsOfEnvironment();
    EXPECT_GT(fine, 1000);
    EXPECT_GT(coarse, 1000);
}

/// What a brick's maker tells is what its samples have; and so of each block what lies anywhere in it.
TEST(GridRanges, HoldWhateverLiesInABlock) {
    test::Random random(12);
    std::size_t bricks = 0;
    for (int i = 0; i < 40; ++i) {
        const glm::uvec3 source(1 + random.below(40), 1 + random.below(30), 1 + random.below(20));
        const test::HybridShape shape{
            .source = source,
            .low = {1 + random.below(source.x), 1 + random.below(source.y), 1 + random.below(source.z)},
            .threshold = random.magnitude(-4, 0),
            .parts = random.chance(0.5) ? HybridRepresentation::residual : HybridRepresentation::points};
        const double wave = random.magnitude(0, 5);
        const auto field = test::hybridOf(shape, [&](const glm::dvec3& at) {
            return 0.5 + 0.5 * std::sin(wave * (at.x + at.y * at.z)) * at.z;
        });
        auto unknown = *field->bricks;
        unknown.ranges.clear();
        for (std::size_t brick = 0; brick < unknown.corrected(); ++brick, ++bricks)
            EXPECT_EQ(field->bricks->rangeOf(brick), unknown.rangeOf(brick));
        const VolumeSamples samples(*field);
        const auto ranges = gridRanges({.grid = field, .bricks = true});
        for (int k = 0; k < 200; ++k) {
            const glm::dvec3 place =
                samples.cells() * glm::dvec3(random.unit(), random.unit(), random.unit());
            const glm::uvec3 block(glm::max(place - 0.5, 0.0) / 8.0);
            const auto& range =
                ranges.ranges()[(std::size_t{block.z} * ranges.count().y + block.y) * ranges.count().x +
                                block.x];
            const double value = field->valueOf(static_cast<double>(samples.code(glm::vec3(place))));
            EXPECT_GE(value, static_cast<double>(range.low) - 1e-6);
            EXPECT_LE(value, static_cast<double>(range.high) + 1e-6);
        }
    }
    EXPECT_GT(bricks, 150U);
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

}  // namespace
}  // namespace mote::render
