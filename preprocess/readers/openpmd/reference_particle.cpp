// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/openpmd/reference_particle.h"

#include <cmath>

#include "preprocess/readers/hdf5/h5_attribute.h"
#include "preprocess/readers/units.h"

namespace mote::prep {

Result<std::optional<ReferenceParticle>> ReferenceParticle::open(const H5Object& species) {
    const auto gamma = numberAttribute(species, "gamma_ref");
    if (!gamma) return gamma.error();
    const auto energy = numberAttribute(species, "pt_ref");  // -gamma
    if (!energy) return energy.error();
    const auto mass = numberAttribute(species, "mass_ref");  // kg
    if (!mass) return mass.error();
    const auto time = numberAttribute(species, "t_ref");  // c t, m
    if (!time) return time.error();
    if (!*gamma && !*energy && !*mass) return std::optional<ReferenceParticle>();

    ReferenceParticle reference;
    reference.gamma = *gamma ? **gamma : -energy->value_or(0.0);
    if (!(reference.gamma >= 1.0) || !std::isfinite(reference.gamma)) {
        return Error{ErrorCode::corrupt, species.where + "@gamma_ref",
                     "the reference particle needs a gamma of at least 1"};
    }
    reference.betaGamma = std::sqrt((reference.gamma - 1.0) * (reference.gamma + 1.0));
    reference.mass = mass->value_or(0.0) * massInEv;
    if (!(reference.mass >= 0.0) || !std::isfinite(reference.mass)) {
        return Error{ErrorCode::corrupt, species.where + "@mass_ref", "is no possible mass"};
    }
    reference.time = time->value_or(0.0) / speedOfLight;
    return std::optional<ReferenceParticle>(reference);
}

}  // namespace mote::prep
