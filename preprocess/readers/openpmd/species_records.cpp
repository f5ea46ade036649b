// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a species has besides the records that make the columns of a run: spin, charge state, turn and
// whatever its writer thought of, under its own name and in its own unit.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/openpmd/species.h"

namespace mote::prep {
namespace {

constexpr std::size_t mostLookedAt = 1024;  // of a group's members

constexpr std::array<std::string_view, 15> known{"particlePatches",
                                                 "position",
                                                 "positionOffset",
                                                 "momentum",
                                                 "momentumOffset",
                                                 "time",
                                                 "timeOffset",
                                                 "totalMomentum",
                                                 "weight",
                                                 "weighting",
                                                 "charge",
                                                 "totalMomentumOffset",
                                                 "mass",
                                                 "particleStatus",
                                                 "id"};

/// Of powers of m, kg, s, A, K, mol and cd: "m", "kg m^2 s^-1", "1".
std::string unitOfPowers(const std::optional<std::vector<double>>& powers) {
    static constexpr std::array<std::string_view, 7> units{"m", "kg", "s", "A", "K", "mol", "cd"};
    std::string text;
    for (std::size_t i = 0; powers && i < std::min(powers->size(), units.size()); ++i) {
        const double power = (*powers)[i];
        if (power == 0.0) continue;
        text += fmt::format("{}{}", text.empty() ? "" : " ", units[i]);
        if (power != 1.0) text += fmt::format("^{:g}", power);
    }
    return text.empty() ? "1" : text;
}

}  // namespace

/// Those that have a number for each particle; what cannot be read as such is passed by, as nobody asked for
/// it.
Status OpenpmdSpecies::openOthers(const H5File& file, const H5Object& group) {
    MOTE_ASSIGN_OR_RETURN(const auto children, file.children(group));
    const auto add = [&](const std::string& record, const std::string& component) {
        const auto name = recordOf(component.empty() ? record : fmt::format("{}_{}", record, component));
        if (!name || recordNames_.size() == mostRecords) return;
        auto opened = OpenpmdComponent::open(file, group, record, component);
        if (!opened.ok() || !opened->has_value()) return;
        if ((*opened)->rows().value_or(rows_) != rows_) return;
        recordNames_.push_back({name->name, unitOfPowers((*opened)->unitDimension())});
        records_.push_back(std::move(**opened));
    };
    for (const auto& record : std::span(children).first(std::min(children.size(), mostLookedAt))) {
        if (std::ranges::find(known, record) != known.end()) continue;
        const auto object = file.find(group, record);
        if (!object.ok() || !object->has_value()) continue;
        add(record, "");
        if (!(*object)->group || (!recordNames_.empty() && recordNames_.back().name == record)) continue;
        const auto components = file.children(**object);
        if (!components.ok()) continue;
        for (const auto& component : std::span(*components).first(std::min(components->size(), mostLookedAt)))
            add(record, component);
    }
    return success();
}

}  // namespace mote::prep
