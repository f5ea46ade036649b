// SPDX-License-Identifier: GPL-3.0-or-later
//
// The manifest's densities: the least and the greatest of a leaf in any step, and each step's particles by
// the scaled log density of their leaf. Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/particles/bounds_rule.h"
#include "protocol/scene/log_density.h"

namespace mote::prep {

/// The range of leaves in ascending density, but for those of zero (macro-particles may weigh nothing); empty
/// where there is no other.
Range densityRange(std::span<const float> density);

/// Adds particles to even bins of t over [0, 1], of which the last holds t = 1. `particles` are as many as
/// the leaves' densities; `bins` are resized to as many as the manifest has.
void addToHistogram(std::span<const float> density, std::span<const std::uint32_t> particles,
                    const LogDensity& scale, std::vector<std::uint64_t>& bins);

}  // namespace mote::prep
