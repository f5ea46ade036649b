// SPDX-License-Identifier: GPL-3.0-or-later
//
// Beam-like point sets for tests, the same for the same seed on every machine: a dense core, a thin ring of
// halo around it and filaments out to the border. Pure functions.
#pragma once

#include <vector>

#include "tests/support/memory_step.h"

namespace mote::test {

struct BeamShape {
    std::size_t core = 80000;      ///< particles of the Gaussian core
    std::size_t halo = 8000;       ///< of the ring around it
    std::size_t filaments = 4000;  ///< of the four arms that leave the core
    double coreSigma = 0.07;       ///< of the core, in units of the box; 0.6 and 1.3 times that along y and z
    double haloRadius = 0.36;      ///< of the ring, in units of the box
    double haloThickness = 0.025;  ///< its standard deviation
    bool evenWeights = true;       ///< false: weights from 0.5 to 2
    std::uint64_t seed = 1;
};

/// Particles in [0, 1]^3, the core in the middle.
std::vector<WeightedPoint> beam(const BeamShape& shape);

/// `count` particles spread evenly over the box.
std::vector<WeightedPoint> evenCloud(std::size_t count, std::uint64_t seed);

}  // namespace mote::test
