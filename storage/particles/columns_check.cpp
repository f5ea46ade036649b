// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/particles/columns_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>

#include "protocol/quantity/quantity.h"

namespace mote::storage {
namespace {

constexpr std::size_t longestName = 63;  // of a unit

bool isName(const std::string& name) {
    return checkColumnName(name, "").ok();
}

bool isUnit(std::string_view unit) {
    return unit.size() <= longestName &&
           std::ranges::all_of(unit, [](char c) { return c >= 0x20 && c < 0x7f; });
}

Status checkColumn(const proto::ColumnEntry& column, std::set<std::string_view>& seen) {
    if (!isName(column.name()) || column.name() == "id") return corrupt("name", "is not a column's name");
    if (!seen.insert(column.name()).second) {
        return corrupt("name", fmt::format("\"{}\" is there twice", column.name()));
    }
    if (!isUnit(column.unit())) return corrupt("unit", "is not a unit's name");
    if (!column.type().empty() && column.type() != "f32" && column.type() != "f64") {
        return corrupt("type", "must be \"f32\" or \"f64\"");
    }
    if (std::isfinite(column.max() - column.min()) && column.min() <= column.max()) return success();
    return corrupt("min", "the range must be finite and min not above max");
}

template <class Names>
Status checkDifferent(const Names& names, int most, const char* field) {
    if (names.size() > most) return corrupt(field, fmt::format("has more than {} entries", most));
    std::set<std::string_view> seen;
    for (int i = 0; i < names.size(); ++i) {
        if (isName(names[i]) && seen.insert(names[i]).second) continue;
        return corrupt(fmt::format("{}[{}]", field, i), "is no name, or there twice");
    }
    return success();
}

}  // namespace

Status checkColumns(const proto::ParticlesManifest& particles) {
    if (particles.columns_size() > maxColumns) {
        return corrupt("columns", fmt::format("a plot has at most {} columns", maxColumns));
    }
    std::set<std::string_view> seen;
    for (int i = 0; i < particles.columns_size(); ++i) {
        MOTE_RETURN_IF_ERROR(checkColumn(particles.columns(i), seen), fmt::format("columns[{}]", i));
    }
    if (!(std::isfinite(particles.mass()) && particles.mass() >= 0.0)) {
        return corrupt("mass", "must be finite and not negative");
    }
    if (!isUnit(particles.species())) return corrupt("species", "is not a species' name");
    if (!std::isfinite(particles.particle_charge())) return corrupt("particleCharge", "must be finite");
    if (!isUnit(particles.weight_unit())) return corrupt("weightUnit", "is not a unit's name");
    const auto& lost = particles.lost_particles();
    if (!lost.empty() && lost != "without" && lost != "with" && lost != "only") {
        return corrupt("lostParticles", "must be \"without\", \"with\" or \"only\"");
    }
    return checkDifferent(particles.statistic_names(), maxStatistics, "statisticNames");
}

Status checkStepColumns(const proto::ParticlesManifest& particles, const proto::ParticleStepEntry& step,
                        const FileNames& files) {
    const bool columns = particles.columns_size() > 0 || particles.ids();
    if (columns && !files.contains(step.columns_file())) {
        return corrupt("columnsFile", "is not among the dataset's files");
    }
    if (columns && !files.contains(step.columns_digest())) {
        return corrupt("columnsDigest", "is not among the dataset's files");
    }
    if (!columns && !step.columns_file().empty()) {
        return corrupt("columnsFile", "is there, though the plot has no columns");
    }
    if (step.column_offset_size() != particles.columns_size()) {
        return corrupt("columnOffset", "must have an entry for each column");
    }
    for (const double offset : step.column_offset()) {
        if (!std::isfinite(offset)) return corrupt("columnOffset", "must be finite");
    }
    if (step.column_resolution_size() != 0 && step.column_resolution_size() != particles.columns_size()) {
        return corrupt("columnResolution", "must have an entry for each column, or none");
    }
    for (const double resolution : step.column_resolution()) {
        if (!(std::isfinite(resolution) && resolution >= 0.0)) {
            return corrupt("columnResolution", "must be finite and not negative");
        }
    }
    // A number that is not defined is none.
    if (step.statistics_size() == particles.statistic_names_size()) return success();
    return corrupt("statistics", "must have an entry for each name");
}

}  // namespace mote::storage
