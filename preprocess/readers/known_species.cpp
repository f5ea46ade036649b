// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/known_species.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <iterator>

#include "preprocess/constants.h"
#include "protocol/base/utf8.h"

#include "preprocess/readers/text/number.h"

namespace mote::prep {
namespace {

constexpr double electronMass = 510998.95, protonMass = 938272088.16, muonMass = 105658375.5,
                 neutronMass = 939565420.52, pionMass = 139570390.0;  // eV/c^2, CODATA 2018, PDG
constexpr double atomicMass = 931494102.42;                           // eV/c^2, of one u
// Two electrons more, less what binds them: 13.598 eV and the electron affinity of 0.754 eV.
constexpr double hydrideMass = protonMass + 2 * electronMass - 14.352;
// H2 without one electron: what binds it is 16.25 eV beside two protons and an electron.
constexpr double hydrogenMoleculeMass = 2 * protonMass + electronMass - 16.25;

struct SpeciesName {
    std::string_view written;  // in lower case
    std::string_view name;
    double mass;
    int charge;
};
// The first of a name is what files are given.
constexpr SpeciesName speciesNames[] = {
    {"electron", "electron", electronMass, -1},
    {"electrons", "electron", electronMass, -1},
    {"e-", "electron", electronMass, -1},
    {"positron", "positron", electronMass, 1},
    {"positrons", "positron", electronMass, 1},
    {"e+", "positron", electronMass, 1},
    {"proton", "proton", protonMass, 1},
    {"protons", "proton", protonMass, 1},
    {"p", "proton", protonMass, 1},
    {"p+", "proton", protonMass, 1},
    {"h+", "proton", protonMass, 1},
    {"#1h+", "proton", protonMass, 1},
    {"#1h+1", "proton", protonMass, 1},
    {"antiproton", "antiproton", protonMass, -1},
    {"antiprotons", "antiproton", protonMass, -1},
    {"pbar", "antiproton", protonMass, -1},
    {"hminus", "H-", hydrideMass, -1},
    {"h-", "H-", hydrideMass, -1},
    {"#1h-", "H-", hydrideMass, -1},
    {"#1h-1", "H-", hydrideMass, -1},
    {"h2+", "H2+", hydrogenMoleculeMass, 1},
    {"neutron", "neutron", neutronMass, 0},
    {"antineutron", "antineutron", neutronMass, 0},
    {"deuteron", "deuteron", 1875612942.57, 1},
    {"triton", "triton", 2808921132.98, 1},
    {"helion", "helion", 2808391607.43, 2},
    {"alpha", "alpha", 3727379406.6, 2},
    {"muon", "muon", muonMass, -1},
    {"muons", "muon", muonMass, -1},
    {"mu-", "muon", muonMass, -1},
    {"antimuon", "antimuon", muonMass, 1},
    {"mu+", "antimuon", muonMass, 1},
    {"pion+", "pion+", pionMass, 1},
    {"pi+", "pion+", pionMass, 1},
    {"pion-", "pion-", pionMass, -1},
    {"pi-", "pion-", pionMass, -1},
    {"photon", "photon", 0.0, 0},
    {"photons", "photon", 0.0, 0},
    {"gamma", "photon", 0.0, 0},
};

/// Masses of neutral atoms in u (AME2020).
struct Nuclide {
    int nucleons;
    std::string_view element;  // in lower case
    double mass;
};
constexpr Nuclide nuclides[] = {
    {1, "h", 1.00782503190},
    {2, "h", 2.01410177784},
    {3, "h", 3.01604928132},
    {3, "he", 3.01602932197},
    {4, "he", 4.00260325413},
    {6, "li", 6.0151228874},
    {7, "li", 7.0160034342},
    {9, "be", 9.012183062},
    {10, "b", 10.012936862},
    {11, "b", 11.009305166},
    {12, "c", 12.0},
    {13, "c", 13.00335483534},
    {14, "c", 14.00324198862},
    {14, "n", 14.00307400425},
    {15, "n", 15.00010889827},
    {16, "o", 15.99491461926},
    {17, "o", 16.99913175595},
    {18, "o", 17.99915961214},
    {19, "f", 18.99840316207},
    {20, "ne", 19.9924401753},
    {22, "ne", 21.991385114},
    {23, "na", 22.989769282},
    {24, "mg", 23.985041697},
    {27, "al", 26.981538408},
    {28, "si", 27.97692653442},
    {31, "p", 30.97376199768},
    {32, "s", 31.97207117354},
    {35, "cl", 34.968852694},
    {37, "cl", 36.965902573},
    {36, "ar", 35.967545106},
    {40, "ar", 39.96238312204},
    {39, "k", 38.96370648482},
    {40, "ca", 39.962590850},
    {48, "ca", 47.952522654},
    {48, "ti", 47.947940677},
    {51, "v", 50.943957664},
    {52, "cr", 51.940504714},
    {55, "mn", 54.938043040},
    {56, "fe", 55.934935537},
    {59, "co", 58.933193524},
    {58, "ni", 57.935341650},
    {60, "ni", 59.930785129},
    {63, "cu", 62.929597119},
    {65, "cu", 64.927789476},
    {64, "zn", 63.929141776},
    {84, "kr", 83.911497727},
    {86, "kr", 85.910610625},
    {87, "rb", 86.909180529},
    {107, "ag", 106.905091509},
    {124, "sn", 123.905279619},
    {127, "i", 126.904472592},
    {124, "xe", 123.905885174},
    {129, "xe", 128.904780859},
    {132, "xe", 131.904155083},
    {136, "xe", 135.907214474},
    {133, "cs", 132.905451958},
    {181, "ta", 180.947998528},
    {197, "au", 196.966570103},
    {206, "pb", 205.974465210},
    {207, "pb", 206.975896821},
    {208, "pb", 207.976652005},
    {209, "bi", 208.980398599},
    {232, "th", 232.038053606},
    {235, "u", 235.043928117},
    {238, "u", 238.050786936},
};
constexpr double sameMass = 1e-4;  // relative: sources round, and f32 does too

/// "#12C+3", "#40Ar", "#1H-": nucleons, element, then a sign with the number of charges, 1 unless said.
std::optional<KnownSpecies> nuclideOf(std::string_view written) {
    if (!written.starts_with('#')) return std::nullopt;
    const char* at = written.data() + 1;
    const char* const end = written.data() + written.size();
    int nucleons = 0;
    const auto number = std::from_chars(at, end, nucleons);
    if (number.ec != std::errc() || nucleons < 1) return std::nullopt;
    at = number.ptr;
    const char* const letters = at;
    while (at != end && std::isalpha(static_cast<unsigned char>(*at)) != 0) ++at;
    const std::string element = lower(std::string_view(letters, static_cast<std::size_t>(at - letters)));
    const auto* const found = std::find_if(std::begin(nuclides), std::end(nuclides), [&](const Nuclide& one) {
        return one.nucleons == nucleons && one.element == element;
    });
    if (found == std::end(nuclides)) return std::nullopt;
    KnownSpecies species{std::string(written), found->mass * atomicMass, 0.0, at != end};
    if (at == end) return species;
    const int sign = *at == '+' ? 1 : *at == '-' ? -1 : 0;
    int charges = 1;
    if (sign == 0) return std::nullopt;
    if (++at != end) {
        const auto state = std::from_chars(at, end, charges);
        if (state.ec != std::errc() || state.ptr != end || charges < 0 || charges > 120) return std::nullopt;
    }
    species.mass -= sign * charges * electronMass;
    species.charge = sign * charges * elementaryCharge;
    return species;
}

/// The one nuclide that has so many electrons less than an atom; nothing where masses do not tell.
std::optional<SpeciesByMass> nuclideOf(double mass, double charge) {
    const double state = std::round(charge / elementaryCharge);
    if (!(std::abs(state) >= 1.0 && std::abs(state) <= 120.0)) return std::nullopt;
    if (std::abs(charge - state * elementaryCharge) > sameMass * elementaryCharge) return std::nullopt;
    std::optional<SpeciesByMass> found;
    for (const auto& nuclide : nuclides) {
        const double ion = nuclide.mass * atomicMass - state * electronMass;
        // Files leave the electrons' mass out, too.
        if (std::abs(mass - ion) > sameMass * ion &&
            std::abs(mass - nuclide.mass * atomicMass) > sameMass * ion) {
            continue;
        }
        if (found) return std::nullopt;
        std::string element(nuclide.element);
        element[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(element[0])));
        found = {"#" + std::to_string(nuclide.nucleons) + element + (state > 0 ? "+" : "-") +
                     std::to_string(static_cast<int>(std::abs(state))),
                 false};
    }
    return found;
}

}  // namespace

std::optional<KnownSpecies> speciesOf(std::string_view name) {
    const std::string written = lower(name);
    for (const auto& known : speciesNames) {
        if (known.written != written) continue;
        return KnownSpecies{std::string(known.name), known.mass, known.charge * elementaryCharge, true};
    }
    return nuclideOf(name);
}

std::optional<SpeciesByMass> speciesOf(double mass, double charge) {
    std::optional<SpeciesByMass> found;
    for (const auto& known : speciesNames) {
        if (!(std::abs(mass - known.mass) <= sameMass * known.mass) || known.mass == 0.0) continue;
        if (charge != 0.0 &&
            std::abs(charge - known.charge * elementaryCharge) > sameMass * elementaryCharge) {
            continue;
        }
        if (!found) found = {std::string(known.name), false};
        found->usual = found->usual || known.name != found->name;
    }
    return found ? found : nuclideOf(mass, charge);
}

}  // namespace mote::prep
