// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/units.h"

#include <algorithm>
#include <cctype>
#include <string>
#include <utility>

namespace mote::prep {
namespace {

constexpr double protonMass = 938272088.16;
// Two electrons more, less what binds them: 13.598 eV and the electron affinity of 0.754 eV.
constexpr double hydrideMass = protonMass + 2 * electronMass - 14.352;

constexpr std::pair<std::string_view, double> masses[] = {
    {"electron", electronMass}, {"electrons", electronMass}, {"e-", electronMass},
    {"positron", electronMass}, {"positrons", electronMass}, {"e+", electronMass},
    {"proton", protonMass},     {"protons", protonMass},     {"p", protonMass},
    {"antiproton", protonMass}, {"h+", protonMass},          {"#1h+", protonMass},
    {"hminus", hydrideMass},    {"h-", hydrideMass},         {"#1h-", hydrideMass},
    {"neutron", 939565420.52},  {"deuteron", 1875612942.57}, {"muon", 105658375.5},
    {"antimuon", 105658375.5},  {"mu-", 105658375.5},        {"mu+", 105658375.5},
    {"helion", 2808391607.43},  {"alpha", 3727379406.6},     {"pion+", 139570390.0},
    {"pion-", 139570390.0},
};

}  // namespace

std::optional<double> speciesMass(std::string_view name) {
    std::string lower(name);
    std::transform(lower.begin(), lower.end(), lower.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    for (const auto& [known, mass] : masses) {
        if (known == lower) return mass;
    }
    return std::nullopt;
}

}  // namespace mote::prep
