// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "preprocess/job_kinds.h"
#include "preprocess/particles/live_dataset.h"
#include "preprocess/particles/particles_job.h"
#include "preprocess/readers/particle_reader.h"
#include "protocol/quantity/quantity.h"

namespace mote::prep {
namespace {

constexpr const char* particlesExamples = R"(Examples:
  mote-prep particles run.h5 --axes x,px,y --out plots/beam.mote
  mote-prep particles dtl/fort.1??.gz --axes x,y,energy --format impactz --out dtl.mote
  mote-prep particles "out/beam_%T.h5" --axes x,px,y --bounds-of step --follow --out live.mote
  mote-prep particles beam.mote --axes y,py,delta --out again.mote
  mote-prep particles table.txt --axes x,px,y --map "x=X [mm],px=PX [MeV/c],y=3 [mm]" --out table.mote
  mote-prep particles run.h5 --axes z,x,delta --steps 0:360:10 --bounds x=-0.01:0.01 --out slow.mote

Axes: x y z t px py pz weight; derived r theta xp yp pr p delta gamma energy; in the bunch's own frame zeta tau x_c y_c
px_c py_c pz_c; records of the source by their names; and expressions: --axes "zeta,hypot(x,y),energy*1e-6". Without
--bounds, a plot's bounds are the least and the greatest value over all selected steps, except for values further than
1000 interquartile ranges from a step's median, which are left out and counted.)";

/// The job, and what of its options is no field as it is.
struct ParticlesArguments : AskedJob {
    std::string axes, columns;
    std::vector<std::string> bounds;
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

Status complete(const ParticlesArguments& options, proto::ParticlesJob& job) {
    for (const auto& axis : splitNames(options.axes)) job.add_axes(axis);
    if (!options.columns.empty()) {
        for (const auto& column : splitNames(options.columns)) job.add_columns(column);
    }
    for (const auto& text : options.bounds) {
        MOTE_ASSIGN_OR_RETURN(auto axis, parseBounds(text));
        *job.add_bounds() = std::move(axis);
    }
    if (job.bounds_of() == "run") job.clear_bounds_of();
    return success();
}

void addInputOptions(const cli::Command& command, ParticlesArguments& options) {
    const auto field = [&](const char* path, const char* help, const char* name = "") {
        return fieldOption(command, *options.request.mutable_particles(), path, help, name);
    };
    field("inputs", "The files of one run, a folder of them, or a dataset with columns", "INPUT").required();
    field("format", "How the files are read; default: told by their content")
        .oneOf(particleFormats())
        .valueName("NAME");
    field("species", "openPMD species, needed if there are several; several with commas become one plot")
        .valueName("NAME[,NAME...]");
    field("map",
          "What the columns of a table are: a quantity (x y z t px py pz weight id lost xp yp p delta "
          "gamma p0c mass ...), '=', a column by name or number, its unit in brackets")
        .valueName("\"x=X [mm],px=PX [MeV/c]\"");
    field("steps", "Step indices, the last included").valueName("FIRST:LAST:STRIDE");
    field("follow",
          "The run is still being written: each new step is added at once, until Ctrl-C or the LAST of "
          "--steps");
    command.option(
        "--columns", options.columns,
        "Columns kept beside the points, separated by commas, or none; default: those of the source");
    field("lost",
          "Particles that the source marks as lost: without them (the default), with them, or only them")
        .oneOf({"without", "with", "only"})
        .valueName("WHICH");
    field("impact.frequency", "IMPACT: scaling frequency, Hz").valueName("HZ");
    field("impact.mass", "Rest mass of a particle if the file does not say it, eV/c^2").valueName("EV");
    field("impact.kinetic_energy", "IMPACT: reference kinetic energy, eV").valueName("EV");
    field("impact.current", "IMPACT: beam current, A").valueName("A");
}

void addPlotOptions(const cli::Command& command, ParticlesArguments& options) {
    const auto field = [&](const char* name, const std::string& help) {
        return fieldOption(command, *options.request.mutable_particles(), name, help);
    };
    command.option("--axes", options.axes, "Three axes").required().valueName("A,B,C");
    addOutputOptions(command, options);
    command.option("--bounds", options.bounds, "Fixed bounds of an axis, in its unit; may be repeated")
        .repeatable()
        .valueName("AXIS=MIN:MAX");
    field("bounds_of",
          "What sets the bounds without --bounds: all steps together (run, the default), or each step (step)")
        .oneOf({"run", "step"})
        .valueName("WHAT");
    field("volume_level", fmt::format("The volume has 2^LEVEL cells a side; default {}", defaultVolumeLevel))
        .valueName("LEVEL");
    field("leaf_capacity",
          fmt::format("A leaf with more particles is divided; default {}", defaultLeafCapacity))
        .valueName("N");
    field("max_level", fmt::format("No leaf is divided below this level; default {}", defaultMaxLevel))
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
    runWhenChosen(command, line, options, [options = options.get()](proto::JobRequest& request) {
        return complete(*options, *request.mutable_particles());
    });
}

Result<proto::Manifest> runParticles(const Job& job) {
    const auto& particles = job.request.particles();
    if (particles.append())
        return appendSteps(job.request, job.inputs, job.output, job.resources, job.progress);
    MOTE_RETURN_IF_ERROR(checkParticlesJob(particles), "particles");
    if (particles.follow())
        return followRun(job.request, job.inputs, job.output, job.resources, job.progress);
    return runParticlesJob(job.request, job.inputs, job.output, job.resources, job.progress);
}

}  // namespace

const JobKind particlesJob{proto::JobRequest::kParticles, true, addParticles, runParticles};

}  // namespace mote::prep
