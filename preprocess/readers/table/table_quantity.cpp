// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/table/table_quantity.h"

#include <algorithm>
#include <span>

#include "preprocess/readers/text/number.h"
#include "preprocess/readers/unit_names.h"

namespace mote::prep {
namespace {

using Q = TableQuantity;

struct Known {
    std::string_view name;
    Q quantity;
};

// The first name of each is the one that messages say.
constexpr Known knownNames[] = {
    {"x", Q::x},
    {"position_x", Q::x},
    {"position/x", Q::x},
    {"y", Q::y},
    {"position_y", Q::y},
    {"position/y", Q::y},
    {"z", Q::z},
    {"position_z", Q::z},
    {"position/z", Q::z},
    {"t", Q::t},
    {"time", Q::t},
    {"px", Q::px},
    {"p_x", Q::px},
    {"momentum_x", Q::px},
    {"momentum/x", Q::px},
    {"py", Q::py},
    {"p_y", Q::py},
    {"momentum_y", Q::py},
    {"momentum/y", Q::py},
    {"pz", Q::pz},
    {"p_z", Q::pz},
    {"momentum_z", Q::pz},
    {"momentum/z", Q::pz},
    {"weight", Q::weight},
    {"weighting", Q::weight},
    {"w", Q::weight},
    {"charge", Q::weight},
    {"q", Q::weight},
    {"nmacro", Q::weight},
    {"id", Q::id},
    {"particleid", Q::id},
    {"particle_id", Q::id},
    {"status", Q::status},
    {"particlestatus", Q::beamStatus},
    {"particle_status", Q::beamStatus},
    {"state", Q::state},
    {"lost", Q::lost},
    {"loss", Q::lost},
    {"alive", Q::alive},
    {"xp", Q::slopeX},
    {"x'", Q::slopeX},
    {"xprime", Q::slopeX},
    {"yp", Q::slopeY},
    {"y'", Q::slopeY},
    {"yprime", Q::slopeY},
    {"p", Q::momentum},
    {"ptot", Q::momentum},
    {"p_total", Q::momentum},
    {"p0c", Q::referenceMomentum},
    {"mass", Q::mass},
    {"mass0", Q::mass},
    {"zeta", Q::zeta},
    {"late", Q::late},
    {"delta", Q::delta},
    {"ptau", Q::energyDeviation},
    {"pzeta", Q::scaledDeviation},
    {"gamma", Q::gamma},
    {"ekin", Q::kineticEnergy},
    {"e_kin", Q::kineticEnergy},
    {"kinetic_energy", Q::kineticEnergy},
    {"etot", Q::totalEnergy},
    {"total_energy", Q::totalEnergy},
    {"vx", Q::velocityX},
    {"velocity_x", Q::velocityX},
    {"vy", Q::velocityY},
    {"velocity_y", Q::velocityY},
    {"vz", Q::velocityZ},
    {"velocity_z", Q::velocityZ},
    {"chi", Q::chi},
    {"charge_ratio", Q::chargeRatio},
    {"q0", Q::chargeNumber},
    {"r", Q::radius},
    {"pr", Q::radialMomentum},
    {"pphi", Q::azimuthalMomentum},
};

// Names of momenta that are in units of m c by themselves.
constexpr Known massNames[] = {
    {"gbx", Q::px},          {"gby", Q::py},          {"gbz", Q::pz},          {"ux", Q::px},
    {"uy", Q::py},           {"uz", Q::pz},           {"betax*gamma", Q::px},  {"betay*gamma", Q::py},
    {"betaz*gamma", Q::pz},  {"beta_x*gamma", Q::px}, {"beta_y*gamma", Q::py}, {"beta_z*gamma", Q::pz},
    {"gammabetax", Q::px},   {"gammabetay", Q::py},   {"gammabetaz", Q::pz},   {"gamma*beta_x", Q::px},
    {"gamma*beta_y", Q::py}, {"gamma*beta_z", Q::pz},
};

constexpr double kilogram = massInEv;
constexpr Unit masses[] = {{"ev", 1},           {"kev", 1e3},     {"mev", 1e6},     {"gev", 1e9},
                           {"ev/c^2", 1},       {"kev/c^2", 1e3}, {"mev/c^2", 1e6}, {"gev/c^2", 1e9},
                           {"ev/c2", 1},        {"mev/c2", 1e6},  {"gev/c2", 1e9},  {"kg", kilogram},
                           {"me", electronMass}};
constexpr Unit energies[] = {{"ev", 1}, {"kev", 1e3}, {"mev", 1e6}, {"gev", 1e9}, {"tev", 1e12}};
constexpr Unit charges[] = {{"c", 1},      {"mc", 1e-3},  {"uc", 1e-6}, {"nc", 1e-9},
                            {"pc", 1e-12}, {"fc", 1e-15}, {"ac", 1e-18}};
constexpr Unit slopes[] = {{"rad", 1},     {"1", 1},       {"", 1},
                           {"mrad", 1e-3}, {"urad", 1e-6}, {"\xc2\xb5rad", 1e-6}};
constexpr Unit velocities[] = {{"c", 1}, {"m/s", 1 / speedOfLight}, {"1", 1}};
constexpr Unit numbers[] = {{"1", 1}, {"", 1}, {"%", 1e-2}};
constexpr std::string_view massUnits[] = {"mc", "betagamma", "gammabeta", "#beta#gamma", "1", "mec"};
constexpr std::string_view referenceUnits[] = {"p0", "p0c", "pc", "p/p0", "px/p0", "py/p0"};

bool isMomentum(Q quantity) {
    return quantity == Q::px || quantity == Q::py || quantity == Q::pz || quantity == Q::momentum ||
           quantity == Q::radialMomentum || quantity == Q::azimuthalMomentum;
}

template <class Names>
bool contains(const Names& names, std::string_view name) {
    return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

/// The meaning with a unit; nothing where the unit is none of the quantity's.
std::optional<TableMeaning> withUnit(TableMeaning meaning, std::string_view written) {
    const std::string unit = unitName(written);
    meaning.unitGiven = true;
    meaning.factor = 1.0;
    if (meaning.quantity == Q::weight) meaning.charge = false;
    if (isMomentum(meaning.quantity)) {
        meaning.relative = contains(referenceUnits, unit);
        meaning.inMass = !meaning.relative && contains(massUnits, unit);
        if (meaning.relative || meaning.inMass) return meaning;
    }
    for (const Unit& known : unitsOf(meaning.quantity)) {
        if (known.name != unit) continue;
        meaning.factor = known.factor;
        meaning.charge = meaning.quantity == Q::weight;
        return meaning;
    }
    if (meaning.quantity == Q::weight && (unit == "1" || unit.empty())) return meaning;
    return std::nullopt;
}

/// The meaning of a name without a unit.
std::optional<TableMeaning> plainMeaning(const std::string& name) {
    if (const auto quantity = quantityNamed(name)) {
        TableMeaning meaning;
        meaning.quantity = *quantity;
        meaning.unitGiven = assumedUnit(*quantity).empty();
        meaning.charge = name == "charge" || name == "q";
        if (*quantity == Q::weight) meaning.unitGiven = !meaning.charge;
        // Velocities without a unit are SI's, as places and times are.
        if (unitsOf(*quantity).data() == velocities) meaning.factor = 1 / speedOfLight;
        return meaning;
    }
    for (const Known& known : massNames) {
        if (known.name != name) continue;
        TableMeaning meaning;
        meaning.quantity = known.quantity;
        meaning.inMass = true;
        return meaning;
    }
    return std::nullopt;
}

/// "x_mm", "x/mm", "x mm": the unit behind a sign that names use, too.
std::optional<TableMeaning> splitMeaning(const std::string& name) {
    for (std::size_t at = name.find_first_of("_/ ,"); at != std::string::npos;
         at = name.find_first_of("_/ ,", at + 1)) {
        const auto plain = plainMeaning(std::string(trim(name.substr(0, at))));
        const std::string_view unit = trim(std::string_view(name).substr(at + 1));
        if (!plain || unit.empty() || unit == "1") continue;
        if (const auto meaning = withUnit(*plain, unit)) return meaning;
    }
    return std::nullopt;
}

}  // namespace

std::optional<Q> quantityNamed(std::string_view name) {
    const auto* const found = std::find_if(std::begin(knownNames), std::end(knownNames),
                                           [&](const Known& known) { return known.name == name; });
    return found == std::end(knownNames) ? std::nullopt : std::optional(found->quantity);
}

std::span<const Unit> unitsOf(Q quantity) {
    switch (quantity) {
        case Q::x:
        case Q::y:
        case Q::z:
        case Q::zeta:
        case Q::late:
        case Q::radius:
            return lengths;
        case Q::t:
            return times;
        case Q::referenceMomentum:
            return momenta;
        case Q::mass:
            return masses;
        case Q::kineticEnergy:
        case Q::totalEnergy:
            return energies;
        case Q::slopeX:
        case Q::slopeY:
            return slopes;
        case Q::velocityX:
        case Q::velocityY:
        case Q::velocityZ:
            return velocities;
        case Q::weight:
            return charges;
        default:
            return isMomentum(quantity) ? std::span<const Unit>(momenta) : numbers;
    }
}

bool isMassUnit(std::string_view unit) {
    return contains(massUnits, unit);
}

Result<std::optional<TableMeaning>> tableMeaning(std::string_view name, const std::string& where) {
    name = trim(name);
    const std::size_t open = name.find_first_of("[({");
    const bool bracketed = open != std::string_view::npos && open > 0 &&
                           std::string_view("])}").find(name.back()) != std::string_view::npos;
    if (!bracketed) {
        const std::string plain = lower(name);
        const auto meaning = plainMeaning(plain);
        return meaning ? meaning : splitMeaning(plain);
    }
    const auto plain = plainMeaning(lower(trim(name.substr(0, open))));
    if (!plain) return plain;
    const std::string_view unit = trim(name.substr(open + 1, name.size() - open - 2));
    if (plain->quantity == Q::id || (plain->quantity >= Q::status && plain->quantity <= Q::alive))
        return plain;
    const auto meaning = withUnit(*plain, unit);
    if (meaning) return meaning;
    return unsupported(where, "has the unit '" + std::string(unit) + "', which is not known");
}

bool isTableUnit(std::string_view text) {
    text = trim(text);
    if (text.size() >= 2 && std::string_view("[({").find(text.front()) != std::string_view::npos)
        text = trim(text.substr(1, text.size() - 2));
    const std::string unit = unitName(text);
    if (unit.empty() || unit == "-" || unit == "1") return true;
    if (contains(massUnits, unit) || contains(referenceUnits, unit)) return true;
    for (const Q quantity :
         {Q::x, Q::t, Q::px, Q::mass, Q::kineticEnergy, Q::weight, Q::slopeX, Q::velocityX, Q::gamma}) {
        for (const Unit& known : unitsOf(quantity)) {
            if (known.name == unit) return true;
        }
    }
    return unit == "deg" || unit == "mev";
}

std::string_view assumedUnit(TableQuantity quantity) {
    const auto units = unitsOf(quantity);
    if (units.data() == lengths.data()) return "m";
    if (units.data() == times) return "s";
    if (units.data() == momenta) return "eV/c";
    if (units.data() == masses) return "eV/c^2";
    if (units.data() == energies) return "eV";
    if (units.data() == slopes) return "rad";
    if (units.data() == velocities) return "m/s";
    if (quantity == Q::weight) return "C";
    return "";
}

std::string tableQuantityNames() {
    std::string names;
    std::optional<Q> last;
    for (const Known& known : knownNames) {
        if (last != known.quantity && known.quantity != Q::late) {
            names += (names.empty() ? "" : ", ") + std::string(known.name);
        }
        last = known.quantity;
    }
    return names;
}

}  // namespace mote::prep
