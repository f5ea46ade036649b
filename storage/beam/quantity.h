// SPDX-License-Identifier: GPL-3.0-or-later
//
// Formulas of what is derived from a particle's columns (protocol/scene/derived_quantity.h). One place: plot
// axes, selections, statistics, histograms and colours all come here. Pure functions; docs/NUMBERS.md.
#pragma once

#include <cstddef>
#include <span>

#include "protocol/scene/derived_quantity.h"

namespace mote::storage {

/// What derived quantities need besides a particle's own columns.
struct BeamContext {
    double mass = 0.0;          ///< eV/c^2, of one real particle; 0: not known
    double meanMomentum = 0.0;  ///< eV/c, weighted mean of |p| over the step's live particles; for delta
};

/// The quantity of each of the particles: `columns` as it names them, all of `out`'s size. Not finite where
/// it has none (px/pz at pz = 0). One thread.
void evaluate(const DerivedQuantity& quantity, std::span<const std::span<const double>> columns,
              const BeamContext& context, std::span<double> out);

}  // namespace mote::storage
