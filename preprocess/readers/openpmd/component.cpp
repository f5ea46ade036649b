// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/openpmd/component.h"

#include <algorithm>
#include <cmath>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/hdf5/h5_attribute.h"

namespace mote::prep {
namespace {

constexpr double maxRows = 9007199254740992.0;  // 2^53: beyond it a double cannot count

/// The attribute at the component, or at its record.
Result<std::optional<double>> nearest(const H5Object& component, const H5Object& record, const char* name) {
    auto own = numberAttribute(component, name);
    if (!own || own->has_value()) return own;
    return numberAttribute(record, name);
}

}  // namespace

Result<std::optional<OpenpmdComponent>> OpenpmdComponent::open(const H5File& file, const H5Object& species,
                                                               std::string_view record,
                                                               std::string_view name) {
    MOTE_ASSIGN_OR_RETURN(auto outer, file.find(species, record));
    if (!outer.has_value()) return std::optional<OpenpmdComponent>();
    MOTE_ASSIGN_OR_RETURN(auto inner, file.find(*outer, name));
    if (!inner.has_value()) return std::optional<OpenpmdComponent>();
    H5Object& object = *inner;

    OpenpmdComponent component;
    component.where_ = object.where;
    const bool scalesWithWeight = record == "momentum" || record == "mass" || record == "charge";
    MOTE_RETURN_IF_ERROR(component.readMeaning(*outer, object, scalesWithWeight));
    if (object.group) {
        MOTE_RETURN_IF_ERROR(component.readConstant(object));
    } else {
        MOTE_ASSIGN_OR_RETURN(auto column, H5Column::open(file, std::move(object)));
        component.rows_ = column.rows();
        component.column_ = std::move(column);
    }
    return std::optional<OpenpmdComponent>(std::move(component));
}

Status OpenpmdComponent::readMeaning(const H5Object& record, const H5Object& component,
                                     bool scalesWithWeight) {
    MOTE_ASSIGN_OR_RETURN(const auto unit, nearest(component, record, "unitSI"));
    unitSI_ = unit.value_or(1.0);
    if (!std::isfinite(unitSI_)) return corrupt(where_ + "@unitSI", "is no finite number");
    auto dimension = numbersAttribute(component, "unitDimension");
    if (dimension && !dimension->has_value()) dimension = numbersAttribute(record, "unitDimension");
    if (!dimension) return dimension.error();
    unitDimension_ = std::move(*dimension);
    if (!scalesWithWeight) return success();
    MOTE_ASSIGN_OR_RETURN(const auto macro, nearest(component, record, "macroWeighted"));
    MOTE_ASSIGN_OR_RETURN(const auto power, nearest(component, record, "weightingPower"));
    weightingPower_ = macro.value_or(0.0) != 0.0 ? power.value_or(1.0) : 0.0;
    return success();
}

Status OpenpmdComponent::readConstant(const H5Object& object) {
    MOTE_ASSIGN_OR_RETURN(const auto value, numberAttribute(object, "value"));
    if (!value.has_value()) {
        return notFound(where_, "is neither a dataset nor a constant with the attribute 'value'");
    }
    value_ = *value;
    MOTE_ASSIGN_OR_RETURN(const auto shape, numbersAttribute(object, "shape"));
    if (!shape.has_value()) return success();
    double rows = 1.0;
    for (const double length : *shape) rows *= length;
    if (!(rows >= 0.0 && rows <= maxRows && rows == std::floor(rows))) {
        return corrupt(where_ + "@shape", "is no possible number of particles");
    }
    rows_ = static_cast<std::uint64_t>(rows);
    return success();
}

Status OpenpmdComponent::read(std::uint64_t begin, std::span<double> values) const {
    if (!column_) {
        std::fill(values.begin(), values.end(), value_ * unitSI_);
        return success();
    }
    MOTE_RETURN_IF_ERROR(column_->read(begin, values.size(), values.data()));
    if (unitSI_ != 1.0) {
        for (double& value : values) value *= unitSI_;
    }
    return success();
}

Status OpenpmdComponent::readIntegers(std::uint64_t begin, std::span<std::uint64_t> values) const {
    if (column_) return column_->read(begin, values.size(), values.data());
    const bool fits = value_ >= 0.0 && value_ < 18446744073709551616.0;
    std::fill(values.begin(), values.end(), fits ? static_cast<std::uint64_t>(value_) : 0);
    return success();
}

Result<std::optional<ReferenceParticle>> ReferenceParticle::open(const H5Object& species) {
    MOTE_ASSIGN_OR_RETURN(const auto gamma, numberAttribute(species, "gamma_ref"));
    MOTE_ASSIGN_OR_RETURN(const auto energy, numberAttribute(species, "pt_ref"));  // -gamma
    MOTE_ASSIGN_OR_RETURN(const auto mass, numberAttribute(species, "mass_ref"));  // kg
    MOTE_ASSIGN_OR_RETURN(const auto time, numberAttribute(species, "t_ref"));     // c t, m
    if (!gamma && !energy && !mass) return std::optional<ReferenceParticle>();

    ReferenceParticle reference;
    reference.gamma = gamma ? *gamma : -energy.value_or(0.0);
    reference.time = time.value_or(0.0) / speedOfLight;
    // ImpactX writes lost particles beside a reference particle that it did not fill.
    if (reference.gamma == 0.0) {
        reference.mass = std::max(mass.value_or(0.0) * massInEv, 0.0);
        return std::optional<ReferenceParticle>(reference);
    }
    if (!(reference.gamma >= 1.0) || !std::isfinite(reference.gamma)) {
        return corrupt(species.where + "@gamma_ref", "the reference particle needs a gamma of at least 1");
    }
    reference.betaGamma = std::sqrt((reference.gamma - 1.0) * (reference.gamma + 1.0));
    reference.mass = mass.value_or(0.0) * massInEv;
    if (!(reference.mass >= 0.0) || !std::isfinite(reference.mass)) {
        return corrupt(species.where + "@mass_ref", "is no possible mass");
    }
    return std::optional<ReferenceParticle>(reference);
}

}  // namespace mote::prep
