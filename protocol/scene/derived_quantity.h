// SPDX-License-Identifier: GPL-3.0-or-later
//
// DerivedQuantity: what a particle has a number of besides its columns, as it can be made from them. One
// place for names and units; storage/beam/quantity.h holds the formulas, docs/NUMBERS.md the definitions.
#pragma once

#include <span>
#include <string_view>
#include <vector>

namespace mote {

struct DerivedQuantity {
    enum class Kind { r, theta, xp, yp, pr, p, delta, gamma, energy };

    Kind kind;
    std::string_view name;                  ///< as its kind is called
    std::string_view unit;                  ///< "m", "rad", "eV/c", "1", "eV"
    std::vector<std::string_view> columns;  ///< what it is made from, in the order of its formula
    bool needsMass = false;                 ///< of one particle
};

/// All of them, in a fixed order.
std::span<const DerivedQuantity> derivedQuantities();

/// Null where there is no derived quantity of this name.
const DerivedQuantity* findDerivedQuantity(std::string_view name);

}  // namespace mote
