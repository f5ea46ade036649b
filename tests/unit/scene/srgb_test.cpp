// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/srgb.h"

#include <gtest/gtest.h>

namespace mote {
namespace {

TEST(Srgb, KnownValues) {
    EXPECT_EQ(srgbToLinear(0.0), 0.0);
    EXPECT_NEAR(srgbToLinear(1.0), 1.0, 1e-15);
    EXPECT_NEAR(srgbToLinear(0.5), 0.214041, 1e-6);  // IEC 61966-2-1
    EXPECT_NEAR(linearToSrgb(0.5), 0.735357, 1e-6);
    EXPECT_NEAR(linearToSrgb(0.001), 0.01292, 1e-12);
}

TEST(Srgb, EveryByteComesBack) {
    for (int byte = 0; byte < 256; ++byte) {
        EXPECT_EQ(std::lround(255.0 * linearToSrgb(srgbToLinear(byte / 255.0))), byte);
    }
}

TEST(Srgb, BothWaysAreInverse) {
    for (int i = 0; i <= 10000; ++i) {
        const double x = i / 10000.0;
        // The standard's constants meet to about 1e-8 where its two pieces join.
        EXPECT_NEAR(linearToSrgb(srgbToLinear(x)), x, 1e-7);
        EXPECT_NEAR(srgbToLinear(linearToSrgb(x)), x, 1e-7);
    }
}

TEST(Srgb, Ascends) {
    for (int i = 0; i < 10000; ++i) {
        EXPECT_LT(linearToSrgb(i / 10000.0), linearToSrgb((i + 1) / 10000.0));
        EXPECT_LT(srgbToLinear(i / 10000.0), srgbToLinear((i + 1) / 10000.0));
    }
}

TEST(Srgb, ColorsAreConvertedChannelByChannel) {
    const glm::dvec3 color(0.1, 0.5, 0.9);
    EXPECT_EQ(srgbToLinear(color), glm::dvec3(srgbToLinear(0.1), srgbToLinear(0.5), srgbToLinear(0.9)));
    EXPECT_EQ(linearToSrgb(color), glm::dvec3(linearToSrgb(0.1), linearToSrgb(0.5), linearToSrgb(0.9)));
}

}  // namespace
}  // namespace mote
