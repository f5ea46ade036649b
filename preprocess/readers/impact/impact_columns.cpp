// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/impact/impact_columns.h"

#include <cmath>

#include "preprocess/readers/units.h"

namespace mote::prep {
namespace {

// Columns of a file, from 0.
constexpr std::size_t xColumn = 0, pxColumn = 1, yColumn = 2, pyColumn = 3, longitudinal = 4,
                      energyColumn = 5, chargeColumn = 7, idColumn = 8;

constexpr std::uint32_t bit(std::size_t column) {
    return 1u << column;
}

/// IMPACT-Z writes -(gamma - gamma of the reference particle).
double longitudinalMomentum(double gamma, double gbx, double gby) {
    return std::sqrt((gamma - 1.0) * (gamma + 1.0) - gbx * gbx - gby * gby);
}

}  // namespace

std::uint32_t ImpactColumns::needed(Column column) const {
    const bool z = code == ImpactDeck::Code::impactZ;
    switch (column) {
        case Column::x:
            return bit(xColumn);
        case Column::px:
            return bit(pxColumn);
        case Column::y:
            return bit(yColumn);
        case Column::py:
            return bit(pyColumn);
        case Column::z:
        case Column::t:
            return bit(longitudinal);
        case Column::pz:
            return bit(energyColumn) | (z ? bit(pxColumn) | bit(pyColumn) : 0);
        case Column::weight:
            return hasWeightColumn() ? bit(chargeColumn) : 0;
        case Column::id:
            return hasIdColumn() ? bit(idColumn) : 0;
    }
    return 0;
}

double ImpactColumns::value(Column column, const Row& row) const {
    const bool z = code == ImpactDeck::Code::impactZ;
    const double length = z ? speedOfLight / angularFrequency : 1.0;
    switch (column) {
        case Column::x:
            return row[xColumn] * length;
        case Column::y:
            return row[yColumn] * length;
        case Column::px:
            return row[pxColumn] * mass;
        case Column::py:
            return row[pyColumn] * mass;
        case Column::z: {
            if (!z) return row[longitudinal];
            // A particle that arrives later (a greater phase) lies behind.
            const double beta = std::sqrt((gamma - 1.0) * (gamma + 1.0)) / gamma;
            return -row[longitudinal] * beta * length;
        }
        case Column::t:
            return row[longitudinal] / angularFrequency;
        case Column::pz:
            if (!z) return row[energyColumn] * mass;
            return longitudinalMomentum(gamma - row[energyColumn], row[pxColumn], row[pyColumn]) * mass;
        case Column::weight:
            return hasWeightColumn() ? std::abs(row[chargeColumn]) : weight;
        case Column::id:
            break;
    }
    return 0.0;
}

}  // namespace mote::prep
