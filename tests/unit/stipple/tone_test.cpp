// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/tone.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "server/render/layers/stipple/photograph_tone.h"

namespace mote::render {
namespace {

TEST(Tone, coverAndInkAreInverse) {
    double before = -1.0;
    for (double ink = 0.0; ink <= 1.0; ink += 0.001) {
        const double cover = coverOfInk(ink);
        EXPECT_GT(cover, before);
        before = cover;
        EXPECT_NEAR(inkOfCover(cover), ink, 1e-12);
        EXPECT_GE(cover, ink - 1e-12);  // dots cannot ink more than they cover
    }
    EXPECT_EQ(inkOfCover(solidCover), 1.0);
    EXPECT_EQ(inkOfCover(100.0), 1.0);
    EXPECT_EQ(coverOfInk(1.0), solidCover);
    EXPECT_EQ(inkOfCover(0.0), 0.0);
}

TEST(Tone, dotsThatDoNotMeetInkTheirAreas) {
    EXPECT_NEAR(densityOfInk(0.25, 4.0), 0.25 / (std::numbers::pi * 4.0), 1e-12);
}

/// A hexagonal cell of points a apart has the area sqrt(3) / 2 a^2.
TEST(Tone, densityOfASpacing) {
    EXPECT_NEAR(1.0 / densityOfSpacing(2.0), std::sqrt(3.0) / 2.0 * 4.0, 1e-12);
}

PixelMap halves() {
    return {2, 1, {0.0F, 1.0F}};
}

TEST(PhotographTone, blackGetsTheFullDensityAndWhiteNone) {
    const PhotographTone tone{10.0, 2.0, 1.0, true};
    const auto wanted = wantedDensity(halves(), 200, 100, tone);
    EXPECT_FLOAT_EQ(wanted.at(10, 50), static_cast<float>(tone.fullDensity()));
    EXPECT_EQ(wanted.at(190, 50), 0.0F);
    const auto inverted = wantedDensity(halves(), 200, 100, {10.0, 2.0, 1.0, false});
    EXPECT_EQ(inverted.at(10, 50), 0.0F);
    EXPECT_FLOAT_EQ(inverted.at(190, 50), static_cast<float>(tone.fullDensity()));
}

TEST(PhotographTone, inkIsOneMinusBrightness) {
    const PixelMap grey(1, 1, {0.25F});
    for (const double gamma : {0.5, 1.0, 2.0}) {
        const PhotographTone tone{10.0, 2.0, gamma, true};
        const double share = 1.0 - std::pow(0.25, gamma);
        EXPECT_NEAR(wantedDensity(grey, 10, 10, tone).at(5, 5), share * tone.fullDensity(), 1e-6);
    }
}

TEST(PhotographTone, thePictureLiesInTheMiddle) {
    const PixelMap black(2, 1, {0.0F, 0.0F});
    const auto wanted = wantedDensity(black, 100, 100, {10.0, 2.0, 1.0, true});
    EXPECT_EQ(wanted.at(50, 24), 0.0F);
    EXPECT_GT(wanted.at(50, 25), 0.0F);
    EXPECT_GT(wanted.at(50, 74), 0.0F);
    EXPECT_EQ(wanted.at(50, 75), 0.0F);
}

}  // namespace
}  // namespace mote::render
