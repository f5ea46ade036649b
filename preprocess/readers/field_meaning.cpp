// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/field_meaning.h"

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "preprocess/readers/known_species.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/unit_names.h"

namespace mote::prep {
namespace {

using Kind = FieldMeaning::Kind;

struct Known {
    std::string_view name;
    FieldMeaning meaning;
};

constexpr Known knownNames[] = {
    {"x", {Kind::column, Column::x}},
    {"position_x", {Kind::column, Column::x}},
    {"position/x", {Kind::column, Column::x}},
    {"y", {Kind::column, Column::y}},
    {"position_y", {Kind::column, Column::y}},
    {"position/y", {Kind::column, Column::y}},
    {"z", {Kind::column, Column::z}},
    {"position_z", {Kind::column, Column::z}},
    {"position/z", {Kind::column, Column::z}},
    {"t", {Kind::column, Column::t}},
    {"time", {Kind::column, Column::t}},
    {"px", {Kind::column, Column::px}},
    {"p_x", {Kind::column, Column::px}},
    {"momentum_x", {Kind::column, Column::px}},
    {"momentum/x", {Kind::column, Column::px}},
    {"py", {Kind::column, Column::py}},
    {"p_y", {Kind::column, Column::py}},
    {"momentum_y", {Kind::column, Column::py}},
    {"momentum/y", {Kind::column, Column::py}},
    {"pz", {Kind::column, Column::pz}},
    {"p_z", {Kind::column, Column::pz}},
    {"momentum_z", {Kind::column, Column::pz}},
    {"momentum/z", {Kind::column, Column::pz}},
    {"weight", {Kind::column, Column::weight}},
    {"weighting", {Kind::column, Column::weight}},
    {"w", {Kind::column, Column::weight}},
    {"charge", {Kind::column, Column::weight, 1.0, true}},
    {"q", {Kind::column, Column::weight, 1.0, true}},
    {"id", {Kind::column, Column::id}},
    {"particleid", {Kind::column, Column::id}},
    {"particle_id", {Kind::column, Column::id}},
    {"status", {Kind::status}},
    {"particlestatus", {Kind::beam}},
    {"particle_status", {Kind::beam}},
    {"lost", {Kind::lost}},
    {"alive", {Kind::alive}},
};

constexpr Unit weights[] = {{"1", 1},     {"", 1},      {"c", 1},      {"mc", 1e-3},
                            {"uc", 1e-6}, {"nc", 1e-9}, {"pc", 1e-12}, {"fc", 1e-15}};
constexpr std::string_view massUnits[] = {"mc", "betagamma", "gammabeta", "#beta#gamma", "1"};

std::span<const Unit> unitsOf(Column column) {
    switch (column) {
        case Column::x:
        case Column::y:
        case Column::z:
            return lengths;
        case Column::t:
            return times;
        case Column::px:
        case Column::py:
        case Column::pz:
            return momenta;
        case Column::weight:
            return weights;
        case Column::id:
            break;
    }
    return {};
}

Result<double> unitFactor(Column column, std::string_view written, double mass, const std::string& where) {
    const std::string unit = unitName(written);
    for (const Unit& known : unitsOf(column)) {
        if (known.name == unit) return known.factor;
    }
    if (isMomentum(column) &&
        std::find(std::begin(massUnits), std::end(massUnits), unit) != std::end(massUnits)) {
        if (mass > 0.0) return mass;
        return invalid(where,
                       "is in units of m c; give the particle's mass (impact.mass of the job, eV/c^2)");
    }
    return unsupported(where, "has the unit '" + std::string(written) + "', which is not known");
}

}  // namespace

std::optional<double> speciesMass(std::string_view name) {
    const auto known = speciesOf(name);
    return known ? std::optional(known->mass) : std::nullopt;
}

Result<std::optional<FieldMeaning>> fieldMeaning(std::string_view name, double mass,
                                                 const std::string& where) {
    name = trim(name);
    std::optional<std::string_view> unit;
    const std::size_t open = name.find_first_of("[(");
    if (open != std::string_view::npos && open > 0 && (name.back() == ']' || name.back() == ')')) {
        unit = trim(name.substr(open + 1, name.size() - open - 2));
        name = trim(name.substr(0, open));
    }
    const std::string plain = lower(name);
    const auto* known = std::find_if(std::begin(knownNames), std::end(knownNames),
                                     [&](const Known& candidate) { return candidate.name == plain; });
    if (known == std::end(knownNames)) return std::optional<FieldMeaning>();
    FieldMeaning meaning = known->meaning;
    if (unit && meaning.kind == Kind::column && meaning.column != Column::id) {
        MOTE_ASSIGN_OR_RETURN(const auto factor, unitFactor(meaning.column, *unit, mass, where));
        meaning.factor = factor;
        if (meaning.column == Column::weight) meaning.coulomb = unitName(*unit).ends_with('c');
    }
    return std::optional<FieldMeaning>(meaning);
}

}  // namespace mote::prep
