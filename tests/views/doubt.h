// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the reference says of a scene, and where it leaves open what is right: pixels that change when all is
// moved by as little as single precision cannot tell. Pure functions.
//
// A scene is moved two ways, opposite to each other: each layer and all dots by a thousandth of a pixel
// (golden scenes allow as much, tests/reference/point_hits.cpp), in depth by a few units of the last place of
// a float over the depths that are drawn, each layer by another amount, so that ties are broken either way;
// the knots of volumes' curves by a code of 16 bits; cuts by a millionth of the volume. Where a pixel's
// colour then changes by more than a step of 8 bits, it is in doubt; so is a pixel whose reference has not
// converged, since the moved scenes are drawn with half the samples.
#pragma once

#include <cstdint>
#include <vector>

#include "server/render/layers/scene.h"
#include "tests/support/image.h"

namespace mote::test {

struct Judgement {
    Image expected;
    std::vector<std::uint8_t> doubtful;  ///< one a pixel, not zero where nothing can be said
    double samples = 0.0;                ///< a cell, of the reference
    double doubtfulShare() const;
};

/// With as many samples as it takes, up to a limit.
Judgement judge(const render::Scene& scene);
/// With many more than that limit.
Judgement judgeClosely(const render::Scene& scene);

/// `way`: 1 or -1. Exposed for its test.
render::Scene moved(const render::Scene& scene, double way);

}  // namespace mote::test
