// SPDX-License-Identifier: GPL-3.0-or-later
//
// The cells in which a step's particles are sorted. Particles lie in them as 32-bit fractions of the plot's
// box; cells are told apart by Morton keys, the bits of three indices in turn, x in bit 0, y in bit 1, z in
// bit 2. CellPlan: what the numbers of particles in the cells of a grid say before any is sorted: the octree
// down to the grid's level, and ranges of cells, in Morton order, that can be sorted one by one. No leaf lies
// in two ranges. Values and pure functions; the same for any number of ranks.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "preprocess/particles/bounds_rule.h"
#include "preprocess/particles/octree.h"
#include "preprocess/particles/step_reader.h"

namespace mote::prep {

/// How many particles of a step lie in each cell of a grid, and what else one pass over them tells.
struct CellCount {
    std::vector<std::uint32_t> cells;  ///< by cell of the grid, by Morton key
    std::uint64_t lost = 0, invalid = 0, outside = 0;
    Range weight;  ///< of the particles within the bounds

    void add(const CellCount& other);
};

/// Counts the particles of this rank's blocks. Errors: the source's own, cancelled.
Result<CellCount> countCells(StepReader& reader, const std::array<Range, 3>& bounds, unsigned gridLevel);

/// The sum of all ranks'.
Result<CellCount> sumOfRanks(Communicator& ranks, const CellCount& mine);

/// The low 21 bits of `v`, two zeros behind each.
constexpr std::uint64_t spreadBits(std::uint64_t v) {
    v &= 0x1fffff;
    v = (v | v << 32) & 0x1f00000000ffff;
    v = (v | v << 16) & 0x1f0000ff0000ff;
    v = (v | v << 8) & 0x100f00f00f00f00f;
    v = (v | v << 4) & 0x10c30c30c30c30c3;
    v = (v | v << 2) & 0x1249249249249249;
    return v;
}

/// Undoes spreadBits.
inline std::uint32_t gatherBits(std::uint64_t v) {
    v &= 0x1249249249249249;
    v = (v | v >> 2) & 0x10c30c30c30c30c3;
    v = (v | v >> 4) & 0x100f00f00f00f00f;
    v = (v | v >> 8) & 0x1f0000ff0000ff;
    v = (v | v >> 16) & 0x1f00000000ffff;
    v = (v | v >> 32) & 0x1fffff;
    return static_cast<std::uint32_t>(v);
}

inline std::uint64_t mortonKey(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return spreadBits(x) | spreadBits(y) << 1 | spreadBits(z) << 2;
}

inline std::array<std::uint32_t, 3> mortonCell(std::uint64_t key) {
    return {gatherBits(key), gatherBits(key >> 1), gatherBits(key >> 2)};
}

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

/// The level of the grid for a step of so many rows: finer for more, at most 7.
unsigned gridLevelFor(std::uint64_t rows);

/// Units that are sorted together.
struct PlanRange {
    std::size_t firstUnit = 0;
    std::size_t unitCount = 0;
    std::uint64_t begin = 0;  ///< particles before it, in Morton order
    std::uint64_t count = 0;  ///< particles
};

struct CellPlan {
    unsigned gridLevel = 0;
    OctreeLevels levels;  ///< down to the grid's; weights, and what divided units hold, are not yet known
    std::vector<PlanUnit> units;             ///< in Morton order
    std::vector<PlanRange> ranges;           ///< at least one, fewer than 2^16
    std::vector<std::uint16_t> rangeOfCell;  ///< by cell of the grid

    std::uint64_t particles() const { return ranges.back().begin + ranges.back().count; }
};

/// `counts`, by cell of the grid, are 8^gridLevel numbers.
CellPlan planCells(const std::vector<std::uint32_t>& counts, unsigned gridLevel,
                   const OctreeOptions& options);

}  // namespace mote::prep
