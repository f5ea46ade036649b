// SPDX-License-Identifier: GPL-3.0-or-later
//
// The waterbag against the moments of the uniform six-dimensional ball, and the generator against its known
// answers.
#include "preprocess/synth/waterbag.h"

#include <gtest/gtest.h>

#include <cmath>

#include "preprocess/synth/philox.h"

namespace mote::prep {
namespace {

TEST(Philox, hasTheKnownAnswersOfItsAuthors) {
    // Random123 1.09, kat_vectors, philox4x32 10.
    EXPECT_EQ(philox({0, 0, 0, 0}, 0), (PhiloxBlock{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
    EXPECT_EQ(philox({~0u, ~0u, ~0u, ~0u}, ~std::uint64_t{0}),
              (PhiloxBlock{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
    EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, 0x299f31d0a4093822),
              (PhiloxBlock{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

// In the unit ball of six dimensions <u^2> = 1/8, <u^4> = 3/80, <u^2 v^2> = 1/80, and r^6 is even on [0, 1].
// All tolerances are five standard deviations of the mean of n samples.
TEST(Waterbag, isEvenInTheSixDimensionalBall) {
    constexpr int n = 200'000;
    std::array<double, 6> first{}, second{};
    double products[6][6] = {};
    double sixth = 0.0, squares = 0.0, most = 0.0;
    for (int i = 0; i < n; ++i) {
        const auto point = waterbagPoint(7, static_cast<std::uint64_t>(i));
        const double u[6] = {point[0][0], point[0][1], point[1][0], point[1][1], point[2][0], point[2][1]};
        double r2 = 0.0;
        for (int a = 0; a < 6; ++a) {
            first[a] += u[a];
            second[a] += u[a] * u[a];
            r2 += u[a] * u[a];
            for (int b = 0; b < a; ++b) products[a][b] += u[a] * u[b];
        }
        sixth += r2 * r2 * r2;
        squares += u[0] * u[0] * u[3] * u[3];
        most = std::max(most, r2);
    }
    const double root = std::sqrt(static_cast<double>(n));
    for (int a = 0; a < 6; ++a) {
        EXPECT_NEAR(first[a] / n, 0.0, 5.0 * std::sqrt(1.0 / 8.0) / root);
        EXPECT_NEAR(second[a] / n, 1.0 / 8.0, 5.0 * std::sqrt(3.0 / 80.0 - 1.0 / 64.0) / root);
        for (int b = 0; b < a; ++b) EXPECT_NEAR(products[a][b] / n, 0.0, 5.0 * std::sqrt(1.0 / 80.0) / root);
    }
    EXPECT_NEAR(sixth / n, 0.5, 5.0 * std::sqrt(1.0 / 12.0) / root);
    // <u^4 v^4> = 9/1920 (12 dimensions on: 3*3 / (6*8*10*12) * 6 / 14... bounded by <u^4> = 3/80).
    EXPECT_NEAR(squares / n, 1.0 / 80.0, 5.0 * std::sqrt(3.0 / 80.0) / root);
    EXPECT_LE(most, 1.0);
    EXPECT_GT(most, 0.999);
}

TEST(Waterbag, everyEighthOfTheBallHoldsItsShare) {
    // Shells of equal volume in r^6 against octants of (x, y, z): 8 x 8 cells, chi^2 of 63 degrees of freedom
    // has mean 63 and deviation sqrt(126) = 11.2; six deviations.
    constexpr int n = 64'000;
    std::array<int, 64> count{};
    for (int i = 0; i < n; ++i) {
        const auto p = waterbagPoint(3, static_cast<std::uint64_t>(i));
        double r2 = 0.0;
        for (const auto& plane : p) r2 += plane[0] * plane[0] + plane[1] * plane[1];
        const int shell = std::min(7, static_cast<int>(8.0 * r2 * r2 * r2));
        const int octant = (p[0][0] > 0) + 2 * (p[1][0] > 0) + 4 * (p[2][0] > 0);
        ++count[static_cast<std::size_t>(8 * shell + octant)];
    }
    double chi2 = 0.0;
    for (const int c : count) chi2 += (c - n / 64.0) * (c - n / 64.0) / (n / 64.0);
    EXPECT_LT(chi2, 63.0 + 6.0 * 11.2);
    EXPECT_GT(chi2, 63.0 - 5.0 * 11.2) << "too even to be random";
}

TEST(Waterbag, dependsOnSeedAndIndexAlone) {
    const auto point = waterbagPoint(1, 5'000'000'000);
    waterbagPoint(1, 3);
    EXPECT_EQ(waterbagPoint(1, 5'000'000'000), point);
    EXPECT_NE(waterbagPoint(2, 5'000'000'000), point);
    EXPECT_NE(waterbagPoint(1, 5'000'000'001), point);
    // Indices that agree in their low 32 bits are different particles.
    EXPECT_NE(waterbagPoint(1, 5'000'000'000 - (std::uint64_t{1} << 32)), point);
    EXPECT_NE(waterbagPoint(std::uint64_t{1} << 40, 9), waterbagPoint(0, 9));
}

}  // namespace
}  // namespace mote::prep
