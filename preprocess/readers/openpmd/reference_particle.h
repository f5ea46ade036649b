// SPDX-License-Identifier: GPL-3.0-or-later
//
// ReferenceParticle: the reference particle that ImpactX writes beside a beam whose coordinates are relative
// to it.
//
// ImpactX tracks in the path length s: it writes position/{x, y} in m and position/t = c (arrival - that of
// the reference particle) in m, momentum/{x, y} over the reference momentum and momentum/t = -(gamma -
// gamma_ref) / (beta gamma)_ref. Its positionOffset is the reference particle's place in the laboratory,
// whose axes are not those of the co-moving frame, and is not added. A value.
#pragma once

#include <optional>

#include "preprocess/readers/hdf5/h5_file.h"
#include "protocol/scene/error.h"

namespace mote::prep {

struct ReferenceParticle {
    double gamma = 1.0;      ///< total over rest energy
    double betaGamma = 0.0;  ///< momentum over m c
    double mass = 0.0;       ///< eV/c^2
    double time = 0.0;       ///< s

    double beta() const { return betaGamma / gamma; }
    /// gamma of a particle from its momentum/t.
    double gammaOf(double momentumT) const { return gamma - momentumT * betaGamma; }

    /// Reads the attributes beta_ref, gamma_ref, mass_ref, ... of a species. Nothing where it has none of
    /// them. Errors: corrupt, notFound (an attribute is missing).
    static Result<std::optional<ReferenceParticle>> open(const H5Object& species);
};

}  // namespace mote::prep
