// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "preprocess/job_kinds.h"
#include "preprocess/particles/live_dataset.h"
#include "preprocess/particles/particles_job.h"
#include "preprocess/readers/particle_reader.h"
#include "protocol/quantity/quantity.h"
#include "protocol/scene/fields/facts.h"

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
    auto& job = *options.request.mutable_particles();
    const auto field = [&](const char* path, const char* name = "") {
        return fieldOption(command, job, path, name);
    };
    field("inputs", "INPUT").required();
    field("format").oneOf(particleFormats()).valueName("NAME");
    field("species").valueName("NAME[,NAME...]");
    field("map").valueName("\"x=X [mm],px=PX [MeV/c]\"");
    field("steps").valueName("FIRST:LAST:STRIDE");
    field("follow");
    command.option("--columns", options.columns, helpOf(*job.GetDescriptor()->FindFieldByName("columns")));
    field("lost").valueName("WHICH");
    field("impact.frequency").valueName("HZ");
    field("impact.mass").valueName("EV");
    field("impact.kinetic_energy").valueName("EV");
    field("impact.current").valueName("A");
}

void addPlotOptions(const cli::Command& command, ParticlesArguments& options) {
    auto& job = *options.request.mutable_particles();
    const auto help = [&](const char* name) { return helpOf(*job.GetDescriptor()->FindFieldByName(name)); };
    command.option("--axes", options.axes, help("axes")).required().valueName("A,B,C");
    addOutputOptions(command, options);
    command.option("--bounds", options.bounds, help("bounds")).repeatable().valueName("AXIS=MIN:MAX");
    fieldOption(command, job, "bounds_of").valueName("WHAT");
    fieldOption(command, job, "volume_level").valueName("LEVEL");
    fieldOption(command, job, "leaf_capacity").valueName("N");
    fieldOption(command, job, "max_level").valueName("LEVEL");
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
