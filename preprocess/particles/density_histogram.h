// SPDX-License-Identifier: GPL-3.0-or-later
//
// The manifest's densities: the least and the greatest of a leaf in any step, and each step's particles by
// the scaled log density of their leaf. Pure functions.
#pragma once

#include <cstdint>
#include <vector>

#include "preprocess/particles/bounds_rule.h"
#include "protocol/scene/log_density.h"
#include "storage/particles/particle_step.h"

namespace mote::prep {

/// Of the leaves whose density is above zero (macro-particles may weigh nothing); empty where there is none.
Range densityRange(const storage::Leaves& leaves);

/// Particles in even bins of t over [0, 1]; the last bin holds t = 1.
std::vector<std::uint64_t> densityHistogram(const storage::Leaves& leaves, const LogDensity& scale);

}  // namespace mote::prep
