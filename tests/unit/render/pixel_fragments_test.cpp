// SPDX-License-Identifier: GPL-3.0-or-later
//
// The fragments of a pixel have the mean light of its samples, however they are put together.
#include "server/render/layers/pixel_fragments.h"

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace mote::render {
namespace {

/// Light of a pixel over white.
glm::dvec3 over(const Fragments& fragments) {
    glm::dvec3 color(0.0);
    double left = 1.0;
    for (const auto& one : fragments) {
        color += left * static_cast<double>(one.opacity) * glm::dvec3(one.color);
        left *= 1.0 - static_cast<double>(one.opacity);
    }
    return color + left;
}

TEST(PixelFragments, HaveTheMeanLightOfTheSamples) {
    test::Random random(7);
    for (int i = 0; i < 300; ++i) {
        const double opacity = i % 3 == 0 ? 1.0 : random.unit();
        const double gap = random.oneOf({0.0, 0.01, 0.3, 10.0});
        PixelFragments pixel(PixelFragments::mostSamples, opacity, gap);
        glm::dvec3 mean(0.0);
        for (std::uint32_t sample = 0; sample < PixelFragments::mostSamples; ++sample) {
            double left = 1.0;
            double depth = random.unit();
            for (auto count = random.below(4); count > 0; --count, depth += random.unit()) {
                const glm::dvec3 color(random.unit(), random.unit(), random.unit());
                pixel.add({depth, sample, color});
                mean += left * opacity * color;
                left *= 1.0 - opacity;
            }
            mean += glm::dvec3(left);
        }
        mean /= PixelFragments::mostSamples;
        Fragments fragments;
        pixel.take(3, 4, fragments);
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_NEAR(over(fragments)[channel], mean[channel], 1e-4);
        for (const auto& one : fragments) {
            EXPECT_EQ(one.column, 3U);
            EXPECT_EQ(one.row, 4U);
            EXPECT_GT(one.opacity, 0.0F);
        }
        for (std::size_t k = 1; k < fragments.size(); ++k)
            EXPECT_LE(fragments[k - 1].depth, fragments[k].depth);
    }
}

TEST(PixelFragments, AreOneWhereASurfaceFillsThePixelAndTwoWhereItIsFoldedOrFarApart) {
    const auto count = [](double secondDepth, std::uint32_t secondSample) {
        PixelFragments pixel(PixelFragments::mostSamples, 0.5, 0.1);
        pixel.add({1.0, 0, glm::dvec3(1.0)});
        pixel.add({secondDepth, secondSample, glm::dvec3(1.0)});
        Fragments fragments;
        pixel.take(0, 0, fragments);
        return fragments.size();
    };
    EXPECT_EQ(count(1.05, 1), 1U);
    EXPECT_EQ(count(1.05, 0), 2U);
    EXPECT_EQ(count(1.2, 1), 2U);
}

TEST(PixelFragments, ForgetWhatWasTaken) {
    PixelFragments pixel(1, 1.0, 0.0);
    pixel.add({1.0, 0, glm::dvec3(0.5)});
    Fragments fragments;
    pixel.take(0, 0, fragments);
    ASSERT_EQ(fragments.size(), 1U);
    EXPECT_EQ(fragments[0].opacity, 1.0F);
    pixel.take(1, 0, fragments);
    EXPECT_EQ(fragments.size(), 1U);
}

}  // namespace
}  // namespace mote::render
