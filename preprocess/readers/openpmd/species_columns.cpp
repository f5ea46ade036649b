// SPDX-License-Identifier: GPL-3.0-or-later
//
// How the columns of a species are read; how it is opened stands in species.cpp.
#include <algorithm>
#include <cmath>

#include "preprocess/readers/openpmd/species.h"
#include "preprocess/readers/units.h"

namespace mote::prep {

Status OpenpmdSpecies::read(std::uint64_t begin, std::size_t count, const std::vector<Column>& wanted,
                            ParticleChunk& chunk) {
    chunk.begin = begin;
    chunk.size = count;
    for (const Column column : wanted) {
        if (column == Column::id) {
            chunk.id.resize(count);
            if (id_) {
                MOTE_RETURN_IF_ERROR(id_->readIntegers(begin, chunk.id));
            } else {
                for (std::size_t i = 0; i < count; ++i) chunk.id[i] = begin + i;
            }
            continue;
        }
        chunk[column].resize(count);
        MOTE_RETURN_IF_ERROR(readColumn(column, begin, chunk[column]));
    }
    chunk.lost.assign(count, 0);
    return readLost(begin, chunk.lost);
}

Status OpenpmdSpecies::readColumn(Column column, std::uint64_t begin, std::vector<double>& values) {
    if (column == Column::weight) return readWeight(begin, values);
    if (!has(column)) {
        return Error{ErrorCode::invalidArgument, "", "a column that the run does not have was asked for"};
    }
    if (reference_) return readReferenceColumn(column, begin, values);
    const auto axis = static_cast<std::size_t>(column);
    if (column == Column::t) return readQuantity(timeRecord_, begin, values);
    if (axis < 3) return readQuantity(position_[axis], begin, values);
    if (column == Column::pz && !momentum_[2].value) return readLongitudinalFromTotal(begin, values);
    return readMomentum(momentum_[axis - 4], begin, values);
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
            return Error{ErrorCode::notFound, quantity.value->where(),
                         "is of macro-particles, but 'weighting' is missing"};
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
    for (std::size_t i = 0; i < lost.size(); ++i) lost[i] = scratch_[i] == 1.0 ? 0 : 1;
    return success();
}

}  // namespace mote::prep
