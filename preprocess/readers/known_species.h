// SPDX-License-Identifier: GPL-3.0-or-later
//
// KnownSpecies: kinds of particles by the names that files give them, those of openPMD's SpeciesType above
// all, nuclides among them ("#12C+3"). Values and pure functions.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace mote::prep {

struct KnownSpecies {
    std::string name;         ///< as SpeciesType has it: "electron", "H-", "#12C+3"
    double mass = 0.0;        ///< eV/c^2; 0: not known
    double charge = 0.0;      ///< C, with its sign
    bool chargeKnown = true;  ///< false of a nuclide without a charge state
};

/// By its name, in any letter case. Nothing for a name that is not known.
std::optional<KnownSpecies> speciesOf(std::string_view name);

/// What has this mass (eV/c^2) and, where it is not 0, this charge (C). Nothing where no species has, or two
/// that differ in the sign of a charge that is not known: then the negative of the light ones, as nearly all
/// who do not say mean it, is `usual`.
struct SpeciesByMass {
    std::string name;
    bool usual = false;  ///< another of the same mass has another charge
};
std::optional<SpeciesByMass> speciesOf(double mass, double charge);

}  // namespace mote::prep
