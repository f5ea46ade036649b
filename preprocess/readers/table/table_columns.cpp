// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/table/table_columns.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "preprocess/readers/known_species.h"

namespace mote::prep {
namespace {

using Q = TableQuantity;

constexpr Q statusQuantities[] = {Q::status, Q::beamStatus, Q::state, Q::lost, Q::alive};

}  // namespace

Result<TableColumns> TableColumns::of(const std::vector<TableField>& fields,
                                      const std::vector<TableConstant>& constants, double mass,
                                      const std::string& where) {
    TableColumns columns;
    columns.mass_ = mass;
    for (const TableConstant& constant : constants) {
        columns.items_[static_cast<std::size_t>(constant.quantity)] =
            Item{std::nullopt, constant.value, false};
        if (constant.quantity == Q::chargeNumber) columns.setCharge(constant.value);
        if (constant.quantity == Q::mass && columns.mass_ <= 0.0) columns.mass_ = constant.value;
    }
    for (const TableField& field : fields) MOTE_RETURN_IF_ERROR(columns.add(field, mass, where));
    MOTE_RETURN_IF_ERROR(columns.checkReference(where));
    columns.choose();
    for (std::size_t i = 0; i + 2 < columnCount; ++i) {
        if (!columns.has(static_cast<Column>(i))) continue;
        columns.describe();
        return columns;
    }
    return notFound(where, "names none of the columns x, y, z, t, px, py, pz");
}

Status TableColumns::add(const TableField& field, double mass, const std::string& where) {
    const std::string place = where + ", column " + std::to_string(field.index + 1) + " (" + field.name + ")";
    MOTE_ASSIGN_OR_RETURN(const auto meaning, tableMeaning(field.name, place));
    if (!meaning) return success();
    auto& item = items_[static_cast<std::size_t>(meaning->quantity)];
    if (item && item->field) return corrupt(place, "means the same as a column before it");
    item = Item{field.index, meaning->factor, meaning->relative};
    if (meaning->inMass) {
        if (!(mass > 0.0) && !(mass_ > 0.0)) {
            return invalid(place,
                           "is in units of m c; give the particle's mass (--mass, "
                           "eV/c^2)");
        }
        item->factor = mass_;
    }
    if (meaning->quantity == Q::weight) {
        weightNamed_ = true;
        if (meaning->charge) weightUnit_ = "C";
        const bool unitWritten = field.name.find_first_of("[({") != std::string::npos;
        const bool count = field.name == "weighting" || field.name == "nmacro";
        if (count || (unitWritten && !meaning->charge)) weightUnit_ = "1";
    }
    if (!meaning->unitGiven) {
        assumed_.emplace_back(field.name, std::string(assumedUnit(meaning->quantity)));
    }
    return success();
}

/// Beside a reference momentum, momenta without a unit are in units of it; beside deviations from one that is
/// nowhere, they are of no known unit.
Status TableColumns::checkReference(const std::string& where) const {
    const bool deviations =
        item(Q::zeta) || item(Q::delta) || item(Q::energyDeviation) || item(Q::scaledDeviation);
    for (const Q quantity : {Q::px, Q::py, Q::pz, Q::momentum}) {
        const auto& some = item(quantity);
        if (!some || !some->field || item(Q::referenceMomentum)) continue;
        const bool assumed = std::any_of(assumed_.begin(), assumed_.end(), [&](const auto& each) {
            const auto meaning = tableMeaning(each.first, "");
            return meaning && meaning->has_value() && (*meaning)->quantity == quantity;
        });
        if (!some->relative && !(deviations && assumed)) continue;
        return unsupported(
            where,
            "has momenta in units of the reference momentum, which it does not give: name it with "
            "--map (p0c=5e9 [eV/c]) or in a column p0c, or write the momenta's unit");
    }
    return success();
}

bool TableColumns::hasAll(std::initializer_list<Q> quantities) const {
    return std::all_of(quantities.begin(), quantities.end(),
                       [&](Q quantity) { return item(quantity).has_value(); });
}

std::optional<TableQuantity> TableColumns::wholeMomentum() const {
    if (item(Q::momentum)) return Q::momentum;
    if (hasAll({Q::delta, Q::referenceMomentum})) return Q::delta;
    if (!(mass_ > 0.0) && !massField()) return std::nullopt;
    for (const Q deviation : {Q::energyDeviation, Q::scaledDeviation}) {
        if (hasAll({deviation, Q::referenceMomentum})) return deviation;
    }
    for (const Q energy : {Q::gamma, Q::totalEnergy, Q::kineticEnergy}) {
        if (item(energy)) return energy;
    }
    return std::nullopt;
}

void TableColumns::choose() {
    if (item(Q::referenceMomentum)) {
        const std::vector<std::pair<std::string, std::string>> assumed = std::move(assumed_);
        assumed_.clear();
        for (const auto& each : assumed) {
            const auto meaning = tableMeaning(each.first, "");
            const Q quantity = (*meaning)->quantity;
            if (quantity == Q::px || quantity == Q::py || quantity == Q::pz)
                items_[static_cast<std::size_t>(quantity)]->relative = true;
            else
                assumed_.push_back(each);
        }
    }
    const bool massKnown = mass_ > 0.0 || massField();
    const bool velocity = hasAll({Q::velocityX, Q::velocityY, Q::velocityZ}) && massKnown;
    const bool slopes = hasAll({Q::slopeX, Q::slopeY});
    if (hasAll({Q::px, Q::py})) {
        transverse_ = Way::direct;
    } else if (hasAll({Q::radius, Q::radialMomentum})) {
        transverse_ = Way::rings;
    } else if (velocity) {
        transverse_ = Way::velocity;
    } else if (slopes && (item(Q::pz) || wholeMomentum())) {
        transverse_ = Way::slopes;
    }
    if (item(Q::pz))
        longitudinal_ = Way::direct;
    else if (velocity)
        longitudinal_ = Way::velocity;
    else if (transverse_ == Way::slopes)
        longitudinal_ = Way::slopes;
    else if (transverse_ != Way::none && wholeMomentum())
        longitudinal_ = Way::rest;
}

void TableColumns::describe() {
    std::map<std::string, std::string> byUnit;
    for (const auto& [field, unit] : assumed_) {
        std::string& names = byUnit[unit];
        names += (names.empty() ? "" : ", ") + field;
    }
    for (const auto& [unit, names] : byUnit) {
        notes_.push_back("no unit is given for " + names + ": taken as " + unit);
    }
    const bool relative =
        std::any_of(items_.begin(), items_.end(), [](const auto& some) { return some && some->relative; });
    if (relative) notes_.push_back("momenta are those of the table times the reference momentum");
    if (!item(Q::z) && (item(Q::zeta) || (item(Q::late) && hasReferenceSpeed())))
        notes_.push_back("z and t are relative to the reference particle");
    if (transverse_ == Way::rings) {
        notes_.push_back(
            "the table has rings, of a radius each: a ring becomes one particle, turned about the axis by "
            "the "
            "golden angle from the ring before it");
    }
    if (weightUnit_.empty() && weightNamed_ && item(Q::referenceMomentum)) weightUnit_ = "1";
}

std::optional<std::size_t> TableColumns::massField() const {
    const auto& mass = item(Q::mass);
    return mass && mass_ <= 0.0 ? mass->field : std::nullopt;
}

std::optional<std::size_t> TableColumns::chargeField() const {
    const auto& charge = item(Q::chargeNumber);
    return charge ? charge->field : std::nullopt;
}

void TableColumns::setMass(double fieldValue) {
    const double mass = fieldValue * item(Q::mass)->factor;
    if (mass > 0.0 && std::isfinite(mass)) mass_ = mass;
}

void TableColumns::setCharge(double fieldValue) {
    if (std::isfinite(fieldValue)) charge_ = fieldValue * elementaryCharge;
}

std::string TableColumns::species() const {
    if (!(mass_ > 0.0) || charge_ == 0.0) return "";
    const auto found = speciesOf(mass_, charge_);
    return found ? found->name : "";
}

std::optional<std::size_t> TableColumns::idField() const {
    return item(Q::id) ? item(Q::id)->field : std::nullopt;
}

void TableColumns::addRecords(const std::vector<std::string>& names) {
    for (std::size_t i = 0; i < names.size(); ++i) {
        auto record = recordOf(names[i]);
        if (!record || std::ranges::count(records_, record->name, &SourceRecord::name) > 0) continue;
        records_.push_back(*std::move(record));
        recordFields_.push_back(i);
    }
}

std::size_t TableColumns::recordField(const std::string& name) const {
    const auto found = std::ranges::find(records_, name, &SourceRecord::name);
    return recordFields_[static_cast<std::size_t>(found - records_.begin())];
}

bool TableColumns::has(Column column) const {
    const auto same = static_cast<Q>(column);
    switch (column) {
        case Column::x:
        case Column::y:
            return item(same) || transverse_ == Way::rings;
        case Column::z:
            return item(Q::z) || item(Q::zeta) ||
                   (item(Q::late) && item(Q::referenceMomentum) && (mass_ > 0.0 || massField()));
        case Column::t:
            return item(Q::t) || item(Q::late) ||
                   (item(Q::zeta) && item(Q::referenceMomentum) && (mass_ > 0.0 || massField()));
        case Column::px:
        case Column::py:
            return item(same) || transverse_ != Way::none;
        case Column::pz:
            return longitudinal_ != Way::none;
        case Column::weight:
        case Column::id:
            return item(same).has_value();
    }
    return false;
}

std::vector<TableQuantity> TableColumns::quantitiesOf(Column column) const {
    std::vector<Q> all{static_cast<Q>(column)};
    const auto add = [&](std::initializer_list<Q> more) { all.insert(all.end(), more); };
    if (isMomentum(column)) {
        add({Q::px, Q::py, Q::pz, Q::slopeX, Q::slopeY, Q::velocityX, Q::velocityY, Q::velocityZ,
             Q::radialMomentum, Q::azimuthalMomentum, Q::referenceMomentum, Q::chi, Q::chargeRatio});
        if (const auto whole = wholeMomentum()) all.push_back(*whole);
    } else if (column == Column::z || column == Column::t) {
        if (!item(static_cast<Q>(column))) add({Q::zeta, Q::late, Q::referenceMomentum});
    } else if (column == Column::x || column == Column::y) {
        if (transverse_ == Way::rings) all = {Q::radius};
    }
    return all;
}

std::vector<std::size_t> TableColumns::needed(const std::vector<Column>& wanted) const {
    std::vector<std::size_t> fields;
    const auto add = [&](Q quantity) {
        if (item(quantity) && item(quantity)->field) fields.push_back(*item(quantity)->field);
    };
    for (const Column column : wanted) {
        if (column == Column::id || isRecord(column)) continue;
        for (const Q quantity : quantitiesOf(column)) add(quantity);
    }
    for (const Q quantity : statusQuantities) add(quantity);
    std::sort(fields.begin(), fields.end());
    fields.erase(std::unique(fields.begin(), fields.end()), fields.end());
    return fields;
}

}  // namespace mote::prep
