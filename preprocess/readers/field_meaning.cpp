// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/field_meaning.h"

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "preprocess/readers/known_species.h"
#include "preprocess/readers/table/table_quantity.h"
#include "preprocess/readers/text/number.h"
#include "preprocess/readers/unit_names.h"
#include "protocol/quantity/known_quantity.h"

namespace mote::prep {
namespace {

using Kind = FieldMeaning::Kind;

/// What a field is that fills a column of a run, or tells which particles are lost; nothing of all others.
std::optional<FieldMeaning> meaningOf(const std::string& name) {
    const auto quantity = quantityNamed(name);
    if (!quantity) return std::nullopt;
    FieldMeaning meaning;
    meaning.coulomb = name == "charge" || name == "q";
    if (*quantity <= TableQuantity::id) {
        meaning.column = static_cast<Column>(*quantity);
        return meaning;
    }
    switch (*quantity) {
        case TableQuantity::status:
            meaning.kind = Kind::status;
            return meaning;
        case TableQuantity::beamStatus:
            meaning.kind = Kind::beam;
            return meaning;
        case TableQuantity::lost:
            meaning.kind = Kind::lost;
            return meaning;
        case TableQuantity::alive:
            meaning.kind = Kind::alive;
            return meaning;
        default:
            return std::nullopt;
    }
}

Result<double> unitFactor(Column column, std::string_view written, double mass, const std::string& where) {
    const std::string unit = unitName(written);
    if (column == Column::weight && (unit == "1" || unit.empty())) return 1.0;
    for (const Unit& known : unitsOf(static_cast<TableQuantity>(column))) {
        if (known.name == unit) return known.factor;
    }
    if (isMomentum(column) && isMassUnit(unit)) {
        if (mass > 0.0) return mass;
        return invalid(where, "is in units of m c; give the particle's mass (--mass, eV/c^2)");
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
    const auto known = meaningOf(lower(name));
    if (!known) return known;
    FieldMeaning meaning = *known;
    if (unit && meaning.kind == Kind::column && meaning.column != Column::id) {
        MOTE_ASSIGN_OR_RETURN(const auto factor, unitFactor(meaning.column, *unit, mass, where));
        meaning.factor = factor;
        if (meaning.column == Column::weight) meaning.coulomb = unitName(*unit).ends_with('c');
    }
    return std::optional<FieldMeaning>(meaning);
}

std::optional<SourceRecord> recordOf(std::string_view name) {
    constexpr std::size_t longest = 64;
    name = trim(name);
    std::string_view unit;
    const std::size_t open = name.find_first_of("[(");
    if (open != std::string_view::npos && open > 0 && (name.back() == ']' || name.back() == ')')) {
        unit = trim(name.substr(open + 1, name.size() - open - 2));
        name = trim(name.substr(0, open));
    }
    const bool readable = std::ranges::none_of(name, [](unsigned char c) { return c < 0x20 || c == 0x7f; });
    if (name.empty() || name.size() > longest || unit.size() > longest || !readable) return std::nullopt;
    if (findKnownQuantity(name) != nullptr || name == "id" || name == "lost") return std::nullopt;
    return SourceRecord{std::string(name), std::string(unit.empty() ? "1" : unit)};
}

}  // namespace mote::prep
