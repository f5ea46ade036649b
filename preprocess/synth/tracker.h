// SPDX-License-Identifier: GPL-3.0-or-later
//
// The particles of one chunk as a structure of arrays, and the loops that start them and carry them from dump
// to dump. A chunk belongs to one owner; disjoint ranges of it may be worked on by different threads at once.
// What becomes of a particle depends on the plan, the seed and its index alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "preprocess/synth/channel_plan.h"

namespace mote::prep {

struct ParticleArrays {
    explicit ParticleArrays(std::size_t size) {
        for (auto& column : position) column.resize(size);
        for (auto& column : slope) column.resize(size);
    }
    std::size_t size() const { return position[0].size(); }

    std::array<std::vector<double>, 3> position;  ///< m: x, y, zeta = gamma z
    std::array<std::vector<double>, 3> slope;     ///< rad: x', y', zeta', along the channel
};

/// Fills rows [begin, end) with the mismatched waterbag at the channel's start; row r is particle `first` +
/// r.
void startParticles(const ChannelPlan& plan, std::uint64_t seed, std::uint64_t first,
                    ParticleArrays& particles, std::size_t begin, std::size_t end);

/// Carries rows [begin, end) from the dump before to `dump`.
void trackParticles(const PlanDump& dump, ParticleArrays& particles, std::size_t begin, std::size_t end);

}  // namespace mote::prep
