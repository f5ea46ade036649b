// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/thinning.h"

#include <gtest/gtest.h>

#include <cmath>

#include "server/render/plan/hidden_area.h"

namespace mote::render {
namespace {

TEST(Thinning, PointsOfAnyWeightHideAsMuchAsAllDid) {
    for (const double share : {1.0, 0.5, 0.1}) {
        for (const double pixels : {1.0, 0.5}) {
            const Thinning thinning{.tau = 0.05, .rest = 1.0, .here = 1.0, .pixels = pixels, .most = mostTau};
            const ThinnedWeights weights(thinning, share);
            // What a point of the mean weight has here, whose look is made for it.
            const double mean =
                tauHiding(pixels * pixels * hiddenBy(0.05, 1.0) / weights.share(1.0), 1.0, mostTau);
            for (double weight = 1e-4; weight < 1e3; weight *= 3.0) {
                const double drawn = weights.share(weight);
                EXPECT_GE(drawn, share - 1e-12);
                EXPECT_LE(drawn, 1.0);
                const double hidden = drawn * hiddenBy(mean * weights.weightHere(weight), 1.0);
                const double wanted = pixels * pixels * hiddenBy(0.05 * weight, 1.0);
                EXPECT_NEAR(hidden / wanted, 1.0, 0.01) << share << ' ' << pixels << ' ' << weight;
            }
        }
    }
}

TEST(Thinning, OfTheMeanWeightNoMoreAreDrawnThanAskedFor) {
    // Each would have to hide more than all.
    const Thinning thinning{.tau = 0.2, .rest = 1.0, .here = 1.0, .pixels = 1.0, .most = mostTauUngrown};
    EXPECT_NEAR(ThinnedWeights(thinning, 0.01).share(1.0), 0.01, 1e-9);
    EXPECT_GT(ThinnedWeights(thinning, 0.01).share(10.0), 0.03);
    EXPECT_EQ(ThinnedWeights(thinning, 1.0).share(0.5), 1.0);
}

}  // namespace
}  // namespace mote::render
