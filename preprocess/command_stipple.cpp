// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <memory>

#include "preprocess/job_kinds.h"
#include "preprocess/stipple/stipple_job.h"
#include "preprocess/stipple/surface/surface_job.h"

namespace mote::prep {
namespace {

constexpr const char* stippleExamples = R"(Examples:
  mote-prep stipple plane --points 50000 --seed 1 --out plane.mote
  mote-prep stipple teapot.obj --points 52000 --seed 1 --out teapot.mote)";

/// Options as the command line gives them.
struct StippleArguments : DatasetOptions {
    std::uint64_t points = 0;
    std::uint64_t seed = 1;
    std::optional<std::uint32_t> rings;
    std::optional<double> relaxation;
};

void complete(const StippleArguments& options, proto::StippleJob& job) {
    if (options.input != "plane") job.set_mesh(options.input);
    job.set_points(options.points);
    job.set_seed(options.seed);
    if (options.rings) job.set_rings(*options.rings);
    if (options.relaxation) job.set_relaxation(*options.relaxation);
}

void addStipple(const cli::Command& program, CommandLine& line) {
    const auto command = program.subcommand("stipple", "Make a hierarchy of evenly spread dots");
    const auto options = std::make_shared<StippleArguments>();
    command
        .option("SURFACE", options->input,
                "\"plane\", the periodic unit square, or the file of a triangle mesh")
        .required();
    command.option("--points", options->points, "Points at the highest density").required().valueName("N");
    command.option("--seed", options->seed, "Of the random start; default 1").valueName("S");
    command.option("--rings", options->rings, "Rings of neighbours that move at a removal; default 2")
        .valueName("1|2");
    command.option("--relaxation", options->relaxation, "Of their moves, 1 to 1.9; default 1.6")
        .valueName("W");
    addDatasetOptions(command, line, options,
                      [options](auto& request) { complete(*options, *request.mutable_stipple()); });
    command.footer(stippleExamples);
}

Result<proto::Manifest> runStipple(const Job& job) {
    MOTE_RETURN_IF_ERROR(checkStippleJob(job.request.stipple()), "stipple");
    if (job.inputs.empty()) return runPlaneJob(job.request, job.output, job.resources, job.progress);
    return runSurfaceJob(job.request, job.inputs.front(), job.output, job.resources, job.progress);
}

}  // namespace

const JobKind stippleJob{proto::JobRequest::kStipple, false, addStipple, runStipple};

}  // namespace mote::prep
