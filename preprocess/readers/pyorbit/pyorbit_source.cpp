// SPDX-License-Identifier: GPL-3.0-or-later
//
// Bunches of PyORBIT as runs: what their columns mean.
#include <algorithm>
#include <cmath>

#include "preprocess/readers/field_meaning.h"
#include "preprocess/readers/file_number.h"
#include "preprocess/readers/odd_steps.h"
#include "preprocess/readers/particle_formats.h"
#include "preprocess/readers/pyorbit/pyorbit_bunch.h"

namespace mote::prep {
namespace {

constexpr double giga = 1e9;
constexpr std::size_t deviation = 5;  // the column of E - E0

void give(HeldTable& table, std::string name, std::vector<double> values) {
    table.names.push_back(std::move(name));
    table.values.push_back(std::move(values));
}

Result<double> massOf(const PyorbitBunch& bunch, double mass) {
    if (mass > 0.0) return mass;
    if (bunch.mass > 0.0) return bunch.mass * giga;
    return Error{ErrorCode::unsupported, bunch.name,
                 "says no mass (BUNCH_ATTRIBUTE_DOUBLE mass): give it with --mass"};
}

Result<double> momentumOf(const PyorbitBunch& bunch, double mass) {
    if (bunch.momentum > 0.0) return bunch.momentum * giga;
    const double kinetic = bunch.energy * giga;
    if (kinetic > 0.0) return std::sqrt(kinetic * (kinetic + 2.0 * mass));
    return Error{ErrorCode::unsupported, bunch.name,
                 "says nothing of the synchronous particle, in units of whose momentum its particles' are: "
                 "add a line '% SYNC_PART_MOMENTUM 0 0 1.7' (GeV/c)"};
}

void addAttributes(PyorbitBunch& bunch, HeldTable& table) {
    const auto ids = bunch.find("ParticleIdNumber"), weights = bunch.find("macrosize");
    const auto lost = bunch.find("LostParticleAttributes");
    const std::size_t rows = bunch.values[0].size();
    if (ids) give(table, "id", std::move(bunch.values[*ids]));
    if (weights) give(table, "nmacro", std::move(bunch.values[*weights]));
    if (!weights && bunch.macroSize > 0.0) give(table, "nmacro", std::vector(rows, bunch.macroSize));
    if (!weights && !(bunch.macroSize > 0.0))
        table.notes.emplace_back("the bunch says no macro_size: each particle counts 1");
    if (lost) {
        give(table, "lost", std::vector(rows, 1.0));
        table.notes.emplace_back("the file is one of lost particles: all of them are");
    }
    if (!bunch.attributes.empty() && !ids && !weights && !lost)
        table.notes.emplace_back("attributes of the particles are left out");
}

Result<HeldTable> tableOf(PyorbitBunch bunch, double wantedMass) {
    MOTE_ASSIGN_OR_RETURN(const double mass, massOf(bunch, wantedMass));
    MOTE_ASSIGN_OR_RETURN(const double momentum, momentumOf(bunch, mass));
    HeldTable table;
    table.where = bunch.name;
    table.time = bunch.time;
    for (double& value : bunch.values[deviation]) value *= giga / momentum;
    addAttributes(bunch, table);
    static constexpr const char* names[] = {"x [m]", "px [p0]", "y [m]", "py [p0]", "zeta [m]", "ptau"};
    for (std::size_t i = 0; i <= deviation; ++i) give(table, names[i], std::move(bunch.values[i]));
    table.constants = {{TableQuantity::referenceMomentum, momentum}, {TableQuantity::mass, mass}};
    if (bunch.charge != 0.0) table.constants.push_back({TableQuantity::chargeNumber, bunch.charge});
    return table;
}

}  // namespace

bool looksLikePyorbit(std::string_view begin) {
    return begin.starts_with('%') &&
           (begin.find("PARTICLE_ATTRIBUTES_CONTROLLERS_NAMES") != std::string_view::npos ||
            begin.find("SYNC_PART_") != std::string_view::npos);
}

Result<std::unique_ptr<ParticleSource>> openPyorbit(const std::vector<std::filesystem::path>& paths,
                                                    double mass, Progress& progress) {
    std::vector<HeldTable> tables;
    HeldNumbers held;
    OddSteps odd;
    for (const std::filesystem::path& path : inOrder(paths)) {
        auto bunch = PyorbitBunch::read(path, held, progress);
        auto table = bunch.ok() ? tableOf(std::move(*bunch), mass) : Result<HeldTable>(bunch.error());
        MOTE_RETURN_IF_ERROR(odd.add(table.ok() ? success() : Status(table.error())));
        if (!table.ok()) continue;
        if (paths.size() > 1) table->iteration = fileNumber(path);
        tables.push_back(std::move(*table));
    }
    MOTE_RETURN_IF_ERROR(odd.finish(!tables.empty(), progress));
    return holdTables("pyorbit", std::move(tables), mass, progress);
}

}  // namespace mote::prep
