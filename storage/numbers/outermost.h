// SPDX-License-Identifier: GPL-3.0-or-later
//
// The outermost particles of a step in a plane of phase space: docs/SELECTIONS.md, "Selections". Values and a
// function without state, which uses all threads of the calling arena.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "protocol/scene/error.h"
#include "protocol/scene/selection.h"
#include "storage/beam/quantity_reader.h"
#include "storage/numbers/run_steps.h"

namespace mote::storage {

/// Whether a particle is one of them: its single-particle emittance about the step's own rms ellipse.
struct OutermostTest {
    double meanQ = 0.0, meanP = 0.0;
    double qq = 0.0, qp = 0.0, pp = 0.0;  ///< second moments about the means
    double threshold = 0.0;               ///< of emittance times the rms emittance; what equals it is one
    bool none = true;

    /// <p^2> q^2 - 2 <q p> q p + <q^2> p^2, q and p about their means: the emittance of the ellipse through
    /// the particle, times the rms emittance.
    double emittance(double q, double p) const {
        q -= meanQ;
        p -= meanP;
        return pp * q * q - 2.0 * qp * q * p + qq * p * p;
    }
    bool operator()(double q, double p) const { return !none && emittance(q, p) >= threshold; }
};

/// The columns of a plane: the place and the momentum along it.
std::span<const std::string> planeColumns(char plane);

/// The test of so great a share of the step's weight. A particle without weight above zero, or whose place or
/// momentum is not finite, counts neither in the moments nor in the share. Errors: cancelled; at the name,
/// notFound. Throws StorageError.
Result<OutermostTest> findOutermost(const Selection::Outermost& wanted, const StepNumbers& step,
                                    const std::function<bool()>& cancelled);

}  // namespace mote::storage
