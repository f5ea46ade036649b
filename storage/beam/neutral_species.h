// SPDX-License-Identifier: GPL-3.0-or-later
//
// Species whose particles have no charge: a charge of 0 is none that nobody has said. A pure function.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

namespace mote::storage {

/// By the names of openPMD's SpeciesType, and of nuclides with as many electrons as protons: "#12C+0".
inline bool isNeutral(std::string_view species) {
    static constexpr std::array<std::string_view, 11> names{
        "photon",   "neutron", "antineutron", "electron-neutrino", "muon-neutrino", "tao-neutrino",
        "neutrino", "gluon",   "graviton",    "higgs-boson",       "z-boson"};
    return std::ranges::find(names, species) != names.end() ||
           (species.starts_with('#') && (species.ends_with("+0") || species.ends_with("-0")));
}

}  // namespace mote::storage
