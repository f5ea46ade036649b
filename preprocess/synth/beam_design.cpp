// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/synth/beam_design.h"

#include <cmath>

namespace mote::prep {

BeamKinematics kinematics(const BeamDesign& design) {
    BeamKinematics result;
    const double excess = design.kineticEnergy / protonMassEv;  // gamma - 1, kept apart against cancellation
    const double betaGamma = std::sqrt(excess * (excess + 2.0));
    result.gamma = 1.0 + excess;
    result.beta = betaGamma / result.gamma;
    result.momentum = protonMassEv * betaGamma;
    result.particlesPerBunch = design.current / (design.rfFrequency * elementaryCharge);
    result.perveance = result.particlesPerBunch * classicalProtonRadius / (betaGamma * betaGamma);
    return result;
}

BeamDesign mismatched(BeamDesign design, double mismatch) {
    const double excess = mismatch - 1.0;
    design.mismatch = {1.0 + 1.4 * excess, 1.0 + 0.6 * excess, 1.0 + 1.2 * excess};
    return design;
}

}  // namespace mote::prep
