// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/tone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace mote::render {
namespace {

struct Knot {
    double cover;
    double ink;
};

/// Measured on dots of plane hierarchies (tests/bench/stipple_tone --levels); linear between.
constexpr std::array<Knot, 14> knots{{{0.0, 0.0},
                                      {0.5, 0.5},
                                      {0.6, 0.597},
                                      {0.7, 0.689},
                                      {0.8, 0.770},
                                      {0.9, 0.837},
                                      {1.0, 0.888},
                                      {1.1, 0.925},
                                      {1.2, 0.951},
                                      {1.3, 0.9685},
                                      {1.4, 0.980},
                                      {1.5, 0.988},
                                      {1.6, 0.993},
                                      {solidCover, 1.0}}};

}  // namespace

double inkOfCover(double phi) {
    if (phi >= solidCover) return 1.0;
    const auto above =
        std::find_if(knots.begin() + 1, knots.end(), [&](const Knot& k) { return phi < k.cover; });
    const auto below = above - 1;
    return below->ink +
           (std::max(phi, 0.0) - below->cover) * (above->ink - below->ink) / (above->cover - below->cover);
}

double coverOfInk(double ink) {
    if (ink >= 1.0) return solidCover;
    const auto above =
        std::find_if(knots.begin() + 1, knots.end(), [&](const Knot& k) { return ink < k.ink; });
    const auto below = above - 1;
    return below->cover +
           (std::max(ink, 0.0) - below->ink) * (above->cover - below->cover) / (above->ink - below->ink);
}

double densityOfInk(double ink, double dot) {
    return coverOfInk(ink) / (std::numbers::pi / 4.0 * dot * dot);
}

double densityOfSpacing(double spacing) {
    return 2.0 / (std::numbers::sqrt3 * spacing * spacing);
}

}  // namespace mote::render
