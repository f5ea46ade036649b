// SPDX-License-Identifier: GPL-3.0-or-later
//
// Particles as the job sorts them: their places as 32-bit fractions of the plot's box, and their rows;
// and the cells in which they lie. Pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "preprocess/particles/bounds_rule.h"
#include "preprocess/particles/morton.h"
#include "preprocess/particles/step_reader.h"

namespace mote::prep {

/// floor(2^32 (value - min) / (max - min)) on each axis, at most 2^32 - 1; and the row.
struct Particle {
    std::uint32_t x, y, z;
    std::uint32_t row;
};
static_assert(sizeof(Particle) == 16);

/// Morton key of the cell at `level`, at most 21.
inline std::uint64_t cellOf(const Particle& particle, unsigned level) {
    const unsigned shift = 32 - level;
    if (level == 0) return 0;
    return mortonKey(particle.x >> shift, particle.y >> shift, particle.z >> shift);
}

/// The same for a level of 1 to 7, quicker.
inline std::size_t gridCellOf(const Particle& particle, unsigned level) {
    static constexpr auto spread = [] {
        std::array<std::uint32_t, 128> table{};
        for (std::uint32_t i = 0; i < table.size(); ++i) table[i] = static_cast<std::uint32_t>(spreadBits(i));
        return table;
    }();
    const unsigned shift = 32 - level;
    return spread[particle.x >> shift] | spread[particle.y >> shift] << 1 | spread[particle.z >> shift] << 2;
}

struct QuantizedBlock {
    std::vector<Particle> particles;  ///< by row, ascending
    std::vector<double> weight;       ///< as many
    std::uint64_t outside = 0;        ///< beyond the bounds, left out
};

/// The particles within the bounds. `result`'s memory is used again.
void quantize(const ParticleBlock& block, const std::array<Range, 3>& bounds, QuantizedBlock& result);

}  // namespace mote::prep
