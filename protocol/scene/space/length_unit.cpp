// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/space/length_unit.h"

namespace mote {

std::optional<double> metresOf(std::string_view unit) {
    if (const auto* const own = std::ranges::find(ownLengthUnits, unit, &LengthUnit::name);
        own != ownLengthUnits.end())
        return own->metres;
    const auto* const other = std::ranges::find(otherLengthUnits, unit, &LengthUnit::name);
    return other != otherLengthUnits.end() ? std::optional(other->metres) : std::nullopt;
}

std::string ownName(std::string_view unit) {
    const auto metres = metresOf(unit);
    const auto* const own = std::ranges::find_if(
        ownLengthUnits, [&](const LengthUnit& one) { return metres && one.metres == *metres; });
    return std::string(own != ownLengthUnits.end() ? own->name : unit);
}

std::string lengthUnitNames() {
    std::string names;
    for (const auto& unit : ownLengthUnits) names += (names.empty() ? "" : ", ") + std::string(unit.name);
    return names;
}

const std::string& worldUnit(const proto::Manifest& manifest) {
    return manifest.has_hybrid() ? manifest.hybrid().world_unit() : manifest.world_unit();
}

}  // namespace mote
