// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/synth/waterbag.h"

#include <algorithm>
#include <cmath>

#include "preprocess/synth/philox.h"

namespace mote::prep {
namespace {

/// Even on the unit circle without sine or cosine: a point of the disc with its angle doubled.
std::array<double, 2> circlePoint(ParticleRandom& random) {
    // A point falls outside with a chance of 0.21; 64 times in a row, never in the life of the universe.
    for (int i = 0; i < 64; ++i) {
        const double u = 2.0 * random.next() - 1.0;
        const double v = 2.0 * random.next() - 1.0;
        const double square = u * u + v * v;
        if (square <= 1.0 && square > 0.0) return {(u * u - v * v) / square, 2.0 * u * v / square};
    }
    return {1.0, 0.0};
}

}  // namespace

std::array<std::array<double, 2>, 3> waterbagPoint(std::uint64_t seed, std::uint64_t particle) {
    ParticleRandom random(seed, particle);
    // In action and angle the volume element of each plane is d(r^2)/2 d(phi): the ball is a corner of a cube
    // cut off, r1^2 + r2^2 + r3^2 <= 1, evenly filled. Three sorted numbers cut [0, 1] into such r^2 (and a
    // rest).
    std::array<double, 3> cuts{random.next(), random.next(), random.next()};
    std::sort(cuts.begin(), cuts.end());
    const std::array<double, 3> actions{cuts[0], cuts[1] - cuts[0], cuts[2] - cuts[1]};
    std::array<std::array<double, 2>, 3> point{};
    for (std::size_t plane = 0; plane < 3; ++plane) {
        const auto direction = circlePoint(random);
        const double radius = std::sqrt(actions[plane]);
        point[plane] = {radius * direction[0], radius * direction[1]};
    }
    return point;
}

}  // namespace mote::prep
