// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "preprocess/job_kinds.h"
#include "preprocess/stipple/stipple_job.h"
#include "preprocess/stipple/surface/surface_job.h"

namespace mote::prep {
namespace {

constexpr const char* stippleExamples = R"(Examples:
  mote-prep stipple plane --points 50000 --seed 1 --out plane.mote
  mote-prep stipple teapot.obj --points 52000 --seed 1 --out teapot.mote)";

void addStipple(const cli::Command& program, CommandLine& line) {
    const auto command = program.subcommand("stipple", "Make a hierarchy of evenly spaced dots");
    const auto job = std::make_shared<AskedJob>();
    auto& stipple = *job->request.mutable_stipple();
    fieldOption(command, stipple, "mesh", "SURFACE").required();
    fieldOption(command, stipple, "points").required().valueName("N");
    fieldOption(command, stipple, "seed").valueName("S");
    fieldOption(command, stipple, "rings").valueName("1|2");
    fieldOption(command, stipple, "relaxation").valueName("W");
    addOutlookOptions(command, job->request);
    addDatasetOptions(command, line, job, [](proto::JobRequest& request) {
        if (request.stipple().mesh() == "plane") request.mutable_stipple()->clear_mesh();
        return success();
    });
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
