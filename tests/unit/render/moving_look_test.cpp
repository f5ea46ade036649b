// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/particles/moving_look.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace mote::render {
namespace {

/// What a point hides, square pixels: summed up over a fine lattice, with the coverage of docs/PICTURE.md.
double hiddenByLook(const PointLook& look, double toTau) {
    const double tau = look.light * toTau;
    const auto hides = [&](double coverage) {
        return look.light > 0.0 ? -std::expm1(-tau * coverage) : look.opacity * coverage;
    };
    if (look.size <= 1.0) return look.light > 0.0 ? hides(1.0) : hides(look.size * look.size);
    constexpr int places = 600;
    const double reach = 0.5 * look.size + 0.5, part = 2.0 * reach / places;
    double sum = 0.0;
    for (int i = 0; i < places; ++i) {
        for (int j = 0; j < places; ++j) {
            const double away = std::hypot((i + 0.5) * part - reach, (j + 0.5) * part - reach);
            sum += hides(std::clamp(reach - away, 0.0, 1.0));
        }
    }
    return sum * part * part;
}

TEST(MovingLook, OfAllPointsAndPixelsIsTheLookAtRest) {
    const PointLook look{.size = 2.5, .opacity = 0.3, .light = 0.0};
    EXPECT_EQ(movingLook(look, 1.0, {}), look);
    const PointLook lit{.size = 1.0, .light = 0.1};
    EXPECT_EQ(movingLook(lit, 0.25, {}), lit);
}

TEST(MovingLook, WhatIsLeftHidesAsMuchAsAllDid) {
    for (const double pixels : {1.0, 0.5, 1.0 / 3.0}) {
        for (const double share : {1.0, 0.5, 0.2, 0.03}) {
            for (const double size : {1.0, 1.6, 4.0, 11.0}) {
                for (const double toTau : {1.0, 0.25}) {
                    const PointLook lit{.size = size, .light = 0.2 / toTau};
                    const PointLook plain{.size = size, .opacity = 0.4};
                    for (const auto& rest : {lit, plain}) {
                        const auto moving = movingLook(rest, toTau, {pixels, share});
                        // Within what the lattice sums to.
                        EXPECT_NEAR(hiddenByLook(moving, toTau) * share / (pixels * pixels) /
                                        hiddenByLook(rest, toTau),
                                    1.0, 0.005)
                            << pixels << ' ' << share << ' ' << size;
                        EXPECT_LE(-std::expm1(-moving.light * toTau), 0.7001);
                        EXPECT_LE(moving.opacity, rest.light > 0.0 ? 1.0 : 0.9501);
                    }
                }
            }
        }
    }
}

TEST(MovingLook, PointsGrowOnlyWhereTheyWouldHideMoreThanAll) {
    const PointLook rest{.size = 1.0, .light = 0.2};
    EXPECT_EQ(movingLook(rest, 1.0, {.share = 0.3}).size, 1.0);
    EXPECT_GT(movingLook(rest, 1.0, {.share = 0.1}).size, 1.0);
    const PointLook opaque{.size = 1.0, .opacity = 0.9999};
    EXPECT_EQ(movingLook(opaque, 1.0, {.pixels = 0.5}).size, 0.5);
    EXPECT_GT(movingLook(opaque, 1.0, {.share = 0.5}).size, 1.2);
}

TEST(MovingLook, ManyPointsOfAPixelStayPixels) {
    const std::uint64_t many = 10'000'000;
    const auto less = LessDrawn::of(1.0, 0.1, 1.0, many);
    EXPECT_FALSE(less.grows);
    EXPECT_EQ(movingLook({.size = 1.0, .light = 0.2}, 1.0, less).size, 1.0);
    EXPECT_EQ(movingLook({.size = 1.0, .opacity = 0.9}, 1.0, less).size, 1.0);
    EXPECT_TRUE(LessDrawn::of(1.0, 0.01, 1.0, many).grows) << "few are drawn";
    EXPECT_TRUE(LessDrawn::of(1.0, 0.1, 2.0, many).grows) << "they are discs already";
}

}  // namespace
}  // namespace mote::render
