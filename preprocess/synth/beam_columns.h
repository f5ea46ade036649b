// SPDX-License-Identifier: GPL-3.0-or-later
//
// BeamColumns: a chunk of one step in the units of the file. One owner; disjoint rows may be filled by
// different threads at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "preprocess/synth/tracker.h"

namespace mote::prep {

struct BeamColumns {
    explicit BeamColumns(std::size_t rows);

    std::array<std::vector<float>, 3> position;   ///< m; z is the distance from the synchronous particle
    std::array<std::vector<double>, 3> momentum;  ///< eV/c
    std::vector<std::uint64_t> id;
};

/// Rows [begin, end) of `particles`, whose row r is particle `first` + r, in the file's units.
void fillColumns(const ChannelPlan& plan, const ParticleArrays& particles, std::uint64_t first,
                 std::size_t begin, std::size_t end, BeamColumns& columns);

}  // namespace mote::prep
