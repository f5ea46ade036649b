// SPDX-License-Identifier: GPL-3.0-or-later
//
// QuantizedStep: the particles of a step within the plot's bounds, their places as 32-bit fractions of the
// box. A value.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "preprocess/particles/bounds_rule.h"
#include "preprocess/particles/step_particles.h"

namespace mote::prep {

struct QuantizedStep {
    using Place =
        std::array<std::uint32_t, 3>;  ///< floor(2^32 (value - min) / (max - min)); at most 2^32 - 1

    std::vector<Place> place;
    std::vector<double> weight;
    std::vector<std::uint32_t> row;  ///< ascending
    std::uint64_t outside = 0;       ///< beyond the bounds, left out

    std::size_t size() const { return row.size(); }
};

/// Takes the particles apart, so that their memory is free when it is done.
QuantizedStep quantize(StepParticles particles, const std::array<Range, 3>& bounds);

}  // namespace mote::prep
