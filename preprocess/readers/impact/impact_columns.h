// SPDX-License-Identifier: GPL-3.0-or-later
//
// ImpactColumns: how a row of an IMPACT particle file becomes a particle. A value.
#pragma once

#include <array>
#include <cstdint>

#include "preprocess/readers/impact/impact_deck.h"
#include "preprocess/readers/impact/number_table.h"
#include "preprocess/readers/particle_source.h"

namespace mote::prep {

struct ImpactColumns {
    using Row = std::array<double, NumberTable::maxColumns>;

    ImpactDeck::Code code = ImpactDeck::Code::impactZ;
    double mass = 0.0;              ///< eV/c^2
    double angularFrequency = 0.0;  ///< rad/s, of the scaling (IMPACT-Z)
    double gamma = 1.0;             ///< of the reference particle at this step (IMPACT-Z)
    double weight = 1.0;            ///< of every particle, where the file has no column for it
    std::size_t columns = 0;        ///< of the file

    bool hasWeightColumn() const { return columns >= 8; }
    bool hasIdColumn() const { return columns >= 9; }

    /// The columns of the file that a column of the run needs, one bit each.
    std::uint32_t needed(Column column) const;
    /// A column of the run, but id, from a row of the file. Not a number where it has no value: a particle
    /// whose energy does not carry its transverse momentum.
    double value(Column column, const Row& row) const;
};

}  // namespace mote::prep
