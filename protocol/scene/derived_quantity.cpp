// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/derived_quantity.h"

#include <algorithm>
#include <array>

namespace mote {

std::span<const DerivedQuantity> derivedQuantities() {
    using enum DerivedQuantity::Kind;
    static const std::array<DerivedQuantity, 9> quantities{{
        {r, "r", "m", {"x", "y"}},
        {theta, "theta", "rad", {"x", "y"}},
        {xp, "xp", "rad", {"px", "pz"}},
        {yp, "yp", "rad", {"py", "pz"}},
        {pr, "pr", "eV/c", {"x", "y", "px", "py"}},
        {p, "p", "eV/c", {"px", "py", "pz"}},
        {delta, "delta", "1", {"px", "py", "pz"}},
        {gamma, "gamma", "1", {"px", "py", "pz"}, true},
        {energy, "energy", "eV", {"px", "py", "pz"}, true},
    }};
    return quantities;
}

const DerivedQuantity* findDerivedQuantity(std::string_view name) {
    const auto all = derivedQuantities();
    const auto found = std::ranges::find(all, name, &DerivedQuantity::name);
    return found == all.end() ? nullptr : &*found;
}

}  // namespace mote
