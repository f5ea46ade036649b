// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "preprocess/job_kinds.h"
#include "preprocess/particles/particles_job.h"
#include "preprocess/readers/particle_reader.h"
#include "protocol/quantity/quantity.h"

namespace mote::prep {
namespace {

constexpr const char* particlesExamples = R"(Examples:
  mote-prep particles runParticles.h5 --axes x,px,y --out plots/beam.mote
  mote-prep particles dtl/fort.1??.gz --axes x,y,energy --format impactz --out dtl.mote
  mote-prep particles beam.mote --axes y,py,delta --out again.mote
  mote-prep particles table.txt --axes x,px,y --map "x=X [mm],px=PX [MeV/c],y=3 [mm]" --out table.mote
  mote-prep particles runParticles.h5 --axes z,x,delta --steps 0:360:10 --bounds x=-0.01:0.01 --out slow.mote

Axes: x y z t px py pz weight, derived r theta xp yp pr p delta gamma energy, of the bunch's own frame zeta tau x_c y_c
px_c py_c pz_c, records of the source by their names, and expressions: --axes "zeta,hypot(x,y),energy*1e-6". Without --bounds, a plot's bounds are the least and the
greatest value over all selected steps, but for values further than 1000 interquartile ranges from a step's median,
which are left out and counted.)";

/// Options as the command line gives them.
struct ParticlesArguments {
    std::vector<std::string> inputs;
    std::string axes;
    std::string out;
    std::string title;
    std::string format;
    std::string species;
    std::string steps;
    std::string columns;
    std::string lost;
    std::string map;
    std::vector<std::string> bounds;
    std::string boundsOf;
    std::optional<std::uint32_t> volumeLevel, leafCapacity, maxLevel;
    std::optional<double> frequency, mass, kineticEnergy, current;
    JobResources resources;
};

/// "AXIS=MIN:MAX"
Result<proto::Axis> parseBounds(const std::string& text) {
    const Error wrong{ErrorCode::invalidArgument, "--bounds",
                      fmt::format("\"{}\" is not AXIS=MIN:MAX", text)};
    const auto equals = text.rfind('=');  // an expression may hold one, numbers none
    const auto colon = text.find(':', equals);
    if (equals == std::string::npos || colon == std::string::npos) return wrong;
    const auto least = cli::parseNumber(text.substr(equals + 1, colon - equals - 1));
    const auto greatest = cli::parseNumber(text.substr(colon + 1));
    if (!least || !greatest) return wrong;
    proto::Axis axis;
    axis.set_name(text.substr(0, equals));
    axis.set_min(*least);
    axis.set_max(*greatest);
    return axis;
}

void setImpact(const ParticlesArguments& options, proto::ParticlesJob& job) {
    if (options.frequency) job.mutable_impact()->set_frequency(*options.frequency);
    if (options.mass) job.mutable_impact()->set_mass(*options.mass);
    if (options.kineticEnergy) job.mutable_impact()->set_kinetic_energy(*options.kineticEnergy);
    if (options.current) job.mutable_impact()->set_current(*options.current);
}

Result<proto::JobRequest> toParticlesRequest(const ParticlesArguments& options) {
    proto::JobRequest request;
    request.set_title(options.title);
    request.set_output(options.out);
    auto& job = *request.mutable_particles();
    for (const auto& input : options.inputs) job.add_inputs(input);
    for (const auto& axis : splitNames(options.axes)) job.add_axes(axis);
    job.set_format(options.format == "auto" ? "" : options.format);
    job.set_species(options.species);
    job.set_steps(options.steps);
    if (!options.columns.empty()) {
        for (const auto& column : splitNames(options.columns)) job.add_columns(column);
    }
    job.set_lost(options.lost);
    job.set_map(options.map);
    if (options.volumeLevel) job.set_volume_level(*options.volumeLevel);
    if (options.leafCapacity) job.set_leaf_capacity(*options.leafCapacity);
    if (options.maxLevel) job.set_max_level(*options.maxLevel);
    for (const auto& text : options.bounds) {
        MOTE_ASSIGN_OR_RETURN(auto axis, parseBounds(text));
        *job.add_bounds() = std::move(axis);
    }
    job.set_bounds_of(options.boundsOf == "run" ? "" : options.boundsOf);
    setImpact(options, job);
    return request;
}

void addInputOptions(const cli::Command& command, ParticlesArguments& options) {
    command
        .option("INPUT", options.inputs,
                "The files of one runParticles, a folder of them, or a dataset with columns")
        .required();
    command.option("--format", options.format, "How the files are read; their content tells unless given")
        .oneOf(particleFormats())
        .valueName("NAME");
    command.option("--species", options.species, "openPMD species; needed where there are several")
        .valueName("NAME");
    command
        .option("--map", options.map,
                "What the columns of a table are: a quantity (x y z t px py pz weight id lost xp yp p delta "
                "gamma p0c mass ...), '=', a column by name or number, its unit in brackets")
        .valueName("\"x=X [mm],px=PX [MeV/c]\"");
    command.option("--steps", options.steps, "Step indices, the last included")
        .valueName("FIRST:LAST:STRIDE");
    command.option(
        "--columns", options.columns,
        "Columns kept beside the points, with commas between; none: none. Default: those of the source");
    command
        .option("--lost", options.lost,
                "Particles that the source marks as lost: without (the default), with or only these")
        .oneOf({"without", "with", "only"})
        .valueName("WHICH");
    command.option("--frequency", options.frequency, "IMPACT: scaling frequency, Hz").valueName("HZ");
    command.option("--mass", options.mass, "IMPACT: rest mass, eV/c^2").valueName("EV");
    command.option("--kinetic-energy", options.kineticEnergy, "IMPACT: reference kinetic energy, eV")
        .valueName("EV");
    command.option("--current", options.current, "IMPACT: beam current, A").valueName("A");
}

void addPlotOptions(const cli::Command& command, ParticlesArguments& options) {
    command.option("--axes", options.axes, "Three axes").required().valueName("A,B,C");
    command.option("--out", options.out, "The dataset to make, which must not exist")
        .required()
        .valueName("DIR/NAME.mote");
    command.option("--title", options.title, "What viewers call it").valueName("TEXT");
    command.option("--bounds", options.bounds, "Fixed bounds of an axis, in its unit; may be repeated")
        .repeatable()
        .valueName("AXIS=MIN:MAX");
    command
        .option(
            "--bounds-of", options.boundsOf,
            "Whose values the bounds are without --bounds: all steps' together (run, the default), or each "
            "step's own (step)")
        .oneOf({"run", "step"})
        .valueName("WHAT");
    command
        .option("--volume-level", options.volumeLevel,
                fmt::format("The volume has 2^LEVEL cells a side; default {}", defaultVolumeLevel))
        .valueName("LEVEL");
    command
        .option("--leaf-capacity", options.leafCapacity,
                fmt::format("A leaf with more particles is divided; default {}", defaultLeafCapacity))
        .valueName("N");
    command
        .option("--max-level", options.maxLevel,
                fmt::format("No leaf is divided below this level; default {}", defaultMaxLevel))
        .valueName("LEVEL");
}

void addParticles(const cli::Command& program, CommandLine& line) {
    const auto command = program.subcommand("particles", "Make the hybrid plot of a particle run");
    const auto options = std::make_shared<ParticlesArguments>();
    addInputOptions(command, *options);
    addPlotOptions(command, *options);
    addResourceOptions(command, options->resources);
    addOutputFlags(command, line);
    command.footer(particlesExamples);
    command.callback([options, &line] {
        line.command = [options, &line] {
            const auto request = toParticlesRequest(*options);
            if (!request.ok()) return fail(line, request.error());
            return runAndPrint(line, *request, {}, options->resources);
        };
    });
}

Result<proto::Manifest> runParticles(const Job& job) {
    MOTE_RETURN_IF_ERROR(checkParticlesJob(job.request.particles()), "particles");
    return runParticlesJob(job.request, job.inputs, job.output, job.resources, job.progress);
}

}  // namespace

const JobKind particlesJob{proto::JobRequest::kParticles, true, addParticles, runParticles};

}  // namespace mote::prep
