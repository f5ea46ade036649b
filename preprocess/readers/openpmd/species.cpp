// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/openpmd/species.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/hdf5/h5_attribute.h"

namespace mote::prep {
namespace {

constexpr const char* axisNames[3] = {"x", "y", "z"};

}  // namespace

Result<OpenpmdSpecies> OpenpmdSpecies::open(const H5File& file, const std::string& path,
                                            const std::string& iterationPath, double mass) {
    MOTE_ASSIGN_OR_RETURN(auto group, file.require(file.root(), path));
    MOTE_ASSIGN_OR_RETURN(auto iteration, file.require(file.root(), iterationPath));
    OpenpmdSpecies species;
    MOTE_RETURN_IF_ERROR(species.openRecords(file, group));
    MOTE_RETURN_IF_ERROR(species.checkRows());
    MOTE_RETURN_IF_ERROR(species.openOthers(file, group));
    MOTE_RETURN_IF_ERROR(species.checkMomentumUnits());
    MOTE_RETURN_IF_ERROR(species.findSpecies(group, iteration));
    MOTE_RETURN_IF_ERROR(species.takeMass(mass));
    MOTE_RETURN_IF_ERROR(species.findTime(iteration));
    return species;
}

Status OpenpmdSpecies::openQuantity(const H5File& file, const H5Object& group, Quantity& quantity,
                                    const char* record, const char* offset, const char* component) {
    const std::string name = *component == '\0' ? record : std::string(record) + "/" + component;
    auto value = OpenpmdComponent::open(file, group, record, component);
    if (!value) return drop(name, value.error());
    if (!value->has_value()) return success();
    auto added = OpenpmdComponent::open(file, group, offset, component);
    // An offset that is there and holds nothing adds nothing; one that cannot be read would be missed.
    if (!added && added.error().code == ErrorCode::notFound) {
        notes_.push_back("'" + std::string(offset) + "' of '" + name + "' is empty and is taken for 0");
        added = std::optional<OpenpmdComponent>();
    }
    if (!added) return drop(name, added.error());
    quantity = {name, std::move(*value), std::move(*added)};
    return success();
}

Status OpenpmdSpecies::openRecords(const H5File& file, const H5Object& group) {
    for (std::size_t i = 0; i < 3; ++i) {
        MOTE_RETURN_IF_ERROR(
            openQuantity(file, group, position_[i], "position", "positionOffset", axisNames[i]));
        MOTE_RETURN_IF_ERROR(
            openQuantity(file, group, momentum_[i], "momentum", "momentumOffset", axisNames[i]));
    }
    MOTE_RETURN_IF_ERROR(openQuantity(file, group, positionT_, "position", "positionOffset", "t"));
    MOTE_RETURN_IF_ERROR(openQuantity(file, group, momentumT_, "momentum", "momentumOffset", "t"));
    MOTE_RETURN_IF_ERROR(openQuantity(file, group, timeRecord_, "time", "timeOffset", ""));
    MOTE_RETURN_IF_ERROR(openQuantity(file, group, total_, "totalMomentum", "totalMomentumOffset", ""));
    struct Scalar {
        const char* record;
        std::optional<OpenpmdComponent>& component;
    };
    for (const Scalar& scalar :
         {Scalar{"weighting", weighting_}, Scalar{"weight", charge_}, Scalar{"particleStatus", status_},
          Scalar{"id", id_}, Scalar{"mass", massRecord_}, Scalar{"charge", chargeRecord_}}) {
        auto component = OpenpmdComponent::open(file, group, scalar.record, "");
        if (!component) {
            MOTE_RETURN_IF_ERROR(drop(scalar.record, component.error()));
        } else {
            scalar.component = std::move(*component);
        }
    }
    if (positionT_.value && !position_[2].value) {
        MOTE_ASSIGN_OR_RETURN(auto reference, ReferenceParticle::open(group));
        if (!reference.has_value()) {
            return notFound(
                group.where + "@gamma_ref",
                "is missing: position has t in place of z, which is read relative to a reference particle");
        }
        reference_ = std::move(reference);
        if (!reference_->known()) {
            notes_.push_back(
                "the reference particle has no gamma (as in ImpactX' file of lost particles): z and momenta "
                "are missing");
        }
    }
    return success();
}

Status OpenpmdSpecies::checkMomentumUnits() const {
    if (reference_) return success();
    for (const Quantity& quantity : momentum_) {
        if (!quantity.value || !quantity.value->unitDimension()) continue;
        const auto& powers = *quantity.value->unitDimension();
        if (powers.size() < 3 || (powers[0] == 1.0 && powers[1] == 1.0 && powers[2] == -1.0)) continue;
        return unsupported(quantity.value->where() + "@unitDimension",
                           "is not that of a momentum (1, 1, -1)");
    }
    return success();
}

bool OpenpmdSpecies::has(Column column) const {
    const auto axis = static_cast<std::size_t>(column);
    switch (column) {
        case Column::x:
        case Column::y:
            return position_[axis].value.has_value();
        case Column::z:
            return reference_ ? reference_->known() : position_[2].value.has_value();
        case Column::t:
            return reference_ || timeRecord_.value;
        case Column::px:
        case Column::py:
            return momentum_[axis - 4].value && (!reference_ || (reference_->known() && mass_ > 0.0));
        case Column::pz:
            if (reference_)
                return reference_->known() && momentumT_.value && momentum_[0].value && momentum_[1].value &&
                       mass_ > 0.0;
            return momentum_[2].value || (total_.value && momentum_[0].value && momentum_[1].value);
        case Column::weight:
            return weighting_ || charge_;
        case Column::id:
            return id_.has_value();
    }
    return false;
}

Status OpenpmdSpecies::read(const std::vector<Column>& wanted, const std::vector<SourceRecord>& names,
                            ParticleChunk& chunk) {
    for (const Column column : wanted) {
        if (isRecord(column)) {
            const auto& name = names[static_cast<std::size_t>(column) - columnCount].name;
            MOTE_RETURN_IF_ERROR(readRecord(name, chunk.begin, chunk[column]));
        } else if (column != Column::id) {
            MOTE_RETURN_IF_ERROR(readColumn(column, chunk.begin, chunk[column]));
        } else if (id_) {
            MOTE_RETURN_IF_ERROR(id_->readIntegers(chunk.begin, chunk.id));
        }
    }
    return readLost(chunk.begin, chunk.lost);
}

Status OpenpmdSpecies::readColumn(Column column, std::uint64_t begin, std::vector<double>& values) {
    if (column == Column::weight) return readWeight(begin, values);
    if (broken(column)) {
        std::fill(values.begin(), values.end(), std::numeric_limits<double>::quiet_NaN());
        return success();
    }
    if (!has(column)) return corrupt("", "has changed since it was opened");
    if (reference_) return readReferenceColumn(column, begin, values);
    const auto axis = static_cast<std::size_t>(column);
    if (column == Column::t) return readQuantity(timeRecord_, begin, values);
    if (axis < 3) return readQuantity(position_[axis], begin, values);
    if (column == Column::pz && !momentum_[2].value) return readLongitudinalFromTotal(begin, values);
    return readMomentum(momentum_[axis - 4], begin, values);
}

Status OpenpmdSpecies::readRecord(const std::string& name, std::uint64_t begin, std::vector<double>& values) {
    const auto found = std::ranges::find(recordNames_, name, &SourceRecord::name);
    if (found == recordNames_.end()) return corrupt("", "has changed since it was opened");
    const auto& record = records_[static_cast<std::size_t>(found - recordNames_.begin())];
    MOTE_RETURN_IF_ERROR(record.read(begin, values));
    const double power = record.weightingPower();
    if (power == 0.0 || !weighting_) return success();
    scratch_.resize(values.size());
    MOTE_RETURN_IF_ERROR(weighting_->read(begin, scratch_));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] /= std::pow(scratch_[i], power);
    return success();
}

Status OpenpmdSpecies::readQuantity(const Quantity& quantity, std::uint64_t begin,
                                    std::vector<double>& values) {
    MOTE_RETURN_IF_ERROR(quantity.value->read(begin, values));
    if (!quantity.offset) return success();
    scratch_.resize(values.size());
    MOTE_RETURN_IF_ERROR(quantity.offset->read(begin, scratch_));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += scratch_[i];
    return success();
}

Status OpenpmdSpecies::readMomentum(const Quantity& quantity, std::uint64_t begin,
                                    std::vector<double>& values) {
    MOTE_RETURN_IF_ERROR(readQuantity(quantity, begin, values));
    const double power = quantity.value->weightingPower();
    if (power != 0.0) {
        if (!weighting_)
            return notFound(quantity.value->where(), "is of macro-particles, but 'weighting' is missing");
        scratch_.resize(values.size());
        MOTE_RETURN_IF_ERROR(weighting_->read(begin, scratch_));
        for (std::size_t i = 0; i < values.size(); ++i) {
            values[i] /= power == 1.0 ? scratch_[i] : std::pow(scratch_[i], power);
        }
    }
    for (double& value : values) value *= momentumInEv;
    return success();
}

Status OpenpmdSpecies::readLongitudinalFromTotal(std::uint64_t begin, std::vector<double>& values) {
    MOTE_RETURN_IF_ERROR(readMomentum(total_, begin, values));
    for (double& value : values) value *= value;
    std::vector<double> transverse(values.size());
    for (std::size_t axis = 0; axis < 2; ++axis) {
        MOTE_RETURN_IF_ERROR(readMomentum(momentum_[axis], begin, transverse));
        for (std::size_t i = 0; i < values.size(); ++i) values[i] -= transverse[i] * transverse[i];
    }
    for (double& value : values) value = std::sqrt(value);
    return success();
}

Status OpenpmdSpecies::readReferenceColumn(Column column, std::uint64_t begin, std::vector<double>& values) {
    const ReferenceParticle& reference = *reference_;
    const auto axis = static_cast<std::size_t>(column);
    if (axis < 2) return position_[axis].value->read(begin, values);
    if (column == Column::z || column == Column::t) {
        MOTE_RETURN_IF_ERROR(positionT_.value->read(begin, values));
        const double factor = column == Column::z ? -reference.beta() : 1.0 / speedOfLight;
        for (double& value : values) value *= factor;
        return success();
    }
    const double unit = reference.betaGamma * mass_;
    if (column != Column::pz) {
        MOTE_RETURN_IF_ERROR(momentum_[axis - 4].value->read(begin, values));
        for (double& value : values) value *= unit;
        return success();
    }
    MOTE_RETURN_IF_ERROR(momentumT_.value->read(begin, values));
    for (double& value : values) {
        const double gamma = reference.gammaOf(value);
        value = (gamma - 1.0) * (gamma + 1.0);
    }
    scratch_.resize(values.size());
    for (std::size_t i = 0; i < 2; ++i) {
        MOTE_RETURN_IF_ERROR(momentum_[i].value->read(begin, scratch_));
        for (std::size_t row = 0; row < values.size(); ++row) {
            const double transverse = scratch_[row] * reference.betaGamma;
            values[row] -= transverse * transverse;
        }
    }
    for (double& value : values) value = std::sqrt(value) * mass_;
    return success();
}

Status OpenpmdSpecies::readWeight(std::uint64_t begin, std::vector<double>& values) {
    if (!weighting_ && !charge_) {
        std::fill(values.begin(), values.end(), 1.0);
        return success();
    }
    MOTE_RETURN_IF_ERROR((weighting_ ? *weighting_ : *charge_).read(begin, values));
    for (double& value : values) value = std::abs(value);
    return success();
}

Status OpenpmdSpecies::readLost(std::uint64_t begin, std::vector<std::uint8_t>& lost) {
    if (!status_) return success();
    scratch_.resize(lost.size());
    MOTE_RETURN_IF_ERROR(status_->read(begin, scratch_));
    // Of openPMD's beam physics: 1 live, 0 at the cathode, which is not lost.
    for (std::size_t i = 0; i < lost.size(); ++i) lost[i] = scratch_[i] == 1.0 || scratch_[i] == 0.0 ? 0 : 1;
    return success();
}

}  // namespace mote::prep
