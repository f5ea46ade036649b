// SPDX-License-Identifier: GPL-3.0-or-later
//
// How the rows of a table become those of a run.
#include <algorithm>
#include <cmath>

#include "preprocess/constants.h"
#include "preprocess/readers/table/table_columns.h"

namespace mote::prep {
namespace {

using Q = TableQuantity;

/// The momentum of a mass from what its energy is over it, without the difference of two large numbers.
double momentumOf(double kinetic, double mass) {
    return std::sqrt(kinetic * (kinetic + 2.0 * mass));
}

}  // namespace

TableColumns::Reader TableColumns::reader(Q quantity, const Values& values) const {
    const auto& some = item(quantity);
    if (!some) return {nullptr, 0.0};
    if (!some->field) return {nullptr, some->factor};
    return {values[*some->field], some->factor};
}

/// The momentum in whose units those of a row are: xsuite's are over the mass, too.
double TableColumns::referenceOf(std::size_t row, const Values& values) const {
    double reference = reader(Q::referenceMomentum, values)[row];
    if (item(Q::chi) && item(Q::chargeRatio)) {
        const double chi = reader(Q::chi, values)[row];
        if (chi != 0.0) reference *= reader(Q::chargeRatio, values)[row] / chi;
    }
    return reference;
}

void TableColumns::fillMomentum(const Values& values, std::vector<double>& whole) const {
    const auto way = wholeMomentum();
    if (!way) return;
    const Reader from = reader(*way, values);
    const Reader p0 = reader(Q::referenceMomentum, values);
    for (std::size_t i = 0; i < whole.size(); ++i) {
        const double e0 = std::hypot(p0[i], mass_);
        switch (*way) {
            case Q::momentum:
                whole[i] = from[i] * (item(Q::momentum)->relative ? referenceOf(i, values) : 1.0);
                break;
            case Q::delta:
                whole[i] = referenceOf(i, values) * (1.0 + from[i]);
                break;
            case Q::energyDeviation:
                whole[i] = momentumOf(e0 - mass_ + from[i] * p0[i], mass_);
                break;
            case Q::scaledDeviation:
                whole[i] = momentumOf(e0 - mass_ + from[i] * p0[i] * p0[i] / e0, mass_);
                break;
            case Q::gamma:
                whole[i] = mass_ * std::sqrt((from[i] - 1.0) * (from[i] + 1.0));
                break;
            case Q::totalEnergy:
                whole[i] = momentumOf(from[i] - mass_, mass_);
                break;
            default:
                whole[i] = momentumOf(from[i], mass_);
        }
    }
}

void TableColumns::fillRings(const Values& values, std::size_t begin,
                             std::array<std::vector<double>, 3>& p) const {
    const Reader radial = reader(Q::radialMomentum, values), azimuthal = reader(Q::azimuthalMomentum, values);
    for (std::size_t i = 0; i < p[0].size(); ++i) {
        const double angle = std::fmod(static_cast<double>(begin + i) * goldenAngle, radiansPerTurn);
        p[0][i] = radial[i] * std::cos(angle) - azimuthal[i] * std::sin(angle);
        p[1][i] = radial[i] * std::sin(angle) + azimuthal[i] * std::cos(angle);
    }
}

void TableColumns::fillMomenta(const Values& values, std::size_t begin,
                               std::array<std::vector<double>, 3>& p) const {
    const std::size_t rows = p[0].size();
    const auto direct = [&](std::size_t axis) {
        const auto quantity = static_cast<Q>(static_cast<std::size_t>(Q::px) + axis);
        const Reader from = reader(quantity, values);
        const bool relative = item(quantity) && item(quantity)->relative;
        for (std::size_t i = 0; i < rows; ++i)
            p[axis][i] = relative ? from[i] * referenceOf(i, values) : from[i];
    };
    for (std::size_t axis = 0; axis < 2; ++axis) direct(axis);
    if (transverse_ == Way::rings) fillRings(values, begin, p);
    if (transverse_ == Way::velocity || longitudinal_ == Way::velocity) {
        const Reader v[3] = {reader(Q::velocityX, values), reader(Q::velocityY, values),
                             reader(Q::velocityZ, values)};
        const Reader gamma = reader(Q::gamma, values);
        for (std::size_t i = 0; i < rows; ++i) {
            const double square = v[0][i] * v[0][i] + v[1][i] * v[1][i] + v[2][i] * v[2][i];
            const double factor = mass_ * (item(Q::gamma) ? gamma[i] : 1.0 / std::sqrt(1.0 - square));
            for (std::size_t axis = transverse_ == Way::velocity ? 0 : 2; axis < 3; ++axis)
                p[axis][i] = v[axis][i] * factor;
        }
    }
    if (longitudinal_ == Way::direct) direct(2);
    if (longitudinal_ == Way::rest || longitudinal_ == Way::slopes) fillMomentum(values, p[2]);
    const Reader xp = reader(Q::slopeX, values), yp = reader(Q::slopeY, values);
    for (std::size_t i = 0; i < rows; ++i) {
        if (longitudinal_ == Way::rest)
            p[2][i] = std::sqrt(p[2][i] * p[2][i] - p[0][i] * p[0][i] - p[1][i] * p[1][i]);
        if (longitudinal_ == Way::slopes) p[2][i] /= std::sqrt(1.0 + xp[i] * xp[i] + yp[i] * yp[i]);
        if (transverse_ != Way::slopes) continue;
        p[0][i] = xp[i] * p[2][i];
        p[1][i] = yp[i] * p[2][i];
    }
}

void TableColumns::fillPlace(Column column, const Values& values, ParticleChunk& chunk) const {
    std::vector<double>& out = chunk[column];
    const bool place = column == Column::z;
    const Reader from = reader(item(Q::zeta) ? Q::zeta : Q::late, values);
    const Reader p0 = reader(Q::referenceMomentum, values);
    const bool direct = place ? item(Q::zeta).has_value() : !item(Q::zeta);
    for (std::size_t i = 0; i < out.size(); ++i) {
        const double beta = direct ? 1.0 : p0[i] / std::hypot(p0[i], mass_);
        const double late = item(Q::zeta) ? -from[i] / beta : from[i];  // times c
        out[i] = place ? (item(Q::zeta) ? from[i] : -from[i] * beta) : late / speedOfLight;
    }
}

void TableColumns::fillColumn(Column column, const Values& values, ParticleChunk& chunk) const {
    std::vector<double>& out = chunk[column];
    const bool rings = transverse_ == Way::rings && !item(static_cast<Q>(column));
    if ((column == Column::x || column == Column::y) && rings) {
        const Reader radius = reader(Q::radius, values);
        for (std::size_t i = 0; i < out.size(); ++i) {
            const double angle =
                std::fmod(static_cast<double>(chunk.begin + i) * goldenAngle, radiansPerTurn);
            out[i] = radius[i] * (column == Column::x ? std::cos(angle) : std::sin(angle));
        }
        return;
    }
    if (!item(static_cast<Q>(column)) && column != Column::weight) return fillPlace(column, values, chunk);
    const Reader from = reader(static_cast<Q>(column), values);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = from[i];
    if (column != Column::weight) return;
    for (double& weight : out) weight = item(Q::weight) ? std::abs(weight) : 1.0;
}

void TableColumns::fillLost(const Values& values, ParticleChunk& chunk) const {
    chunk.lost.assign(chunk.size, 0);
    for (const Q quantity : {Q::status, Q::beamStatus, Q::state, Q::lost, Q::alive}) {
        if (!item(quantity)) continue;
        const Reader from = reader(quantity, values);
        for (std::size_t i = 0; i < chunk.size; ++i) {
            const bool lost = quantity == Q::status       ? from[i] != 1.0
                              : quantity == Q::beamStatus ? from[i] != 1.0 && from[i] != 0.0
                              : quantity == Q::state      ? !(from[i] >= 1.0)
                              : quantity == Q::lost       ? from[i] != 0.0
                                                          : from[i] == 0.0;
            chunk.lost[i] |= lost ? 1 : 0;
        }
    }
}

void TableColumns::fill(const std::vector<Column>& wanted, const Values& values, ParticleChunk& chunk) const {
    std::array<std::vector<double>, 3> p;
    for (const Column column : wanted) {
        if (column == Column::id || isRecord(column)) continue;
        chunk[column].assign(chunk.size, 1.0);
        if (column < Column::px || column > Column::pz) {
            fillColumn(column, values, chunk);
            continue;
        }
        if (p[0].empty()) {
            for (auto& axis : p) axis.resize(chunk.size);
            fillMomenta(values, chunk.begin, p);
        }
        chunk[column] = p[static_cast<std::size_t>(column) - static_cast<std::size_t>(Column::px)];
    }
    fillLost(values, chunk);
}

}  // namespace mote::prep
