// SPDX-License-Identifier: GPL-3.0-or-later
//
// Bunches of PyORBIT as runs: what their columns mean.
#include <cmath>

#include "preprocess/readers/pyorbit/pyorbit_bunch.h"

namespace mote::prep {
namespace {

constexpr double giga = 1e9;
constexpr std::size_t deviation = 5;  // the column of E - E0

Result<double> massOfBunch(const PyorbitBunch& bunch, double mass) {
    if (mass > 0.0) return mass;
    if (bunch.mass > 0.0) return bunch.mass * giga;
    return unsupported(bunch.name, "says no mass (BUNCH_ATTRIBUTE_DOUBLE mass): give it with --mass");
}

Result<double> momentumOfBunch(const PyorbitBunch& bunch, double mass) {
    if (bunch.momentum > 0.0) return bunch.momentum * giga;
    const double kinetic = bunch.energy * giga;
    if (kinetic > 0.0) return std::sqrt(kinetic * (kinetic + 2.0 * mass));
    return unsupported(
        bunch.name,
        "says nothing of the synchronous particle, in units of whose momentum its particles' are: "
        "add a line '% SYNC_PART_MOMENTUM 0 0 1.7' (GeV/c)");
}

void addAttributes(PyorbitBunch& bunch, HeldTable& table) {
    const auto ids = bunch.find("ParticleIdNumber"), weights = bunch.find("macrosize");
    const auto lost = bunch.find("LostParticleAttributes");
    const std::size_t rows = bunch.values[0].size();
    if (ids) table.add("id", std::move(bunch.values[*ids]));
    if (weights) table.add("nmacro", std::move(bunch.values[*weights]));
    if (!weights && bunch.macroSize > 0.0) table.add("nmacro", std::vector(rows, bunch.macroSize));
    if (!weights && !(bunch.macroSize > 0.0))
        table.notes.emplace_back("the bunch says no macro_size: each particle counts 1");
    if (lost) {
        table.add("lost", std::vector(rows, 1.0));
        table.notes.emplace_back("the file is one of lost particles: all of them are");
    }
    if (!bunch.attributes.empty() && !ids && !weights && !lost)
        table.notes.emplace_back("attributes of the particles are left out");
}

Result<HeldTable> tableOfPyorbit(const HeldFile& file) {
    MOTE_ASSIGN_OR_RETURN(auto bunch, PyorbitBunch::read(file));
    MOTE_ASSIGN_OR_RETURN(const double mass, massOfBunch(bunch, file.mass));
    MOTE_ASSIGN_OR_RETURN(const double momentum, momentumOfBunch(bunch, mass));
    HeldTable table;
    table.where = bunch.name;
    table.time = bunch.time;
    for (double& value : bunch.values[deviation]) value *= giga / momentum;
    addAttributes(bunch, table);
    static constexpr const char* names[] = {"x [m]", "px [p0]", "y [m]", "py [p0]", "zeta [m]", "ptau"};
    for (std::size_t i = 0; i <= deviation; ++i) table.add(names[i], std::move(bunch.values[i]));
    table.constants = {{TableQuantity::referenceMomentum, momentum}, {TableQuantity::mass, mass}};
    if (bunch.charge != 0.0) table.constants.push_back({TableQuantity::chargeNumber, bunch.charge});
    return table;
}

}  // namespace

extern const ParticleReader pyorbitReader;
constinit const ParticleReader pyorbitReader{
    "pyorbit", "lines '% PARTICLE_ATTRIBUTES'", ParticleReader::Kind::text,
    [](const AskedFile& file) -> Result<bool> {
        const auto says = [&](std::string_view words) { return file.begin.find(words) != file.begin.npos; };
        return file.begin.starts_with('%') &&
               (says("PARTICLE_ATTRIBUTES_CONTROLLERS_NAMES") || says("SYNC_PART_"));
    },
    [](const AskedRun& run, Progress& progress) {
        return openHeld("pyorbit", tableOfPyorbit, run, progress);
    }};

}  // namespace mote::prep
