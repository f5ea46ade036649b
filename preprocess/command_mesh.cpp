// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>
#include <optional>
#include <vector>

#include "preprocess/job_kinds.h"
#include "preprocess/mesh/mesh_job.h"
#include "protocol/scene/job_request.h"

namespace mote::prep {
namespace {

constexpr const char* meshExamples = R"(Examples:
  mote-prep mesh skull.obj --out plots/skull.mote
  mote-prep mesh chest.nrrd --isovalue 220 --clip -100 -100 0 100 100 150 --out plots/bones.mote

INPUT is OBJ, PLY (ASCII, either byte order, strips), STL or OFF, and may be gzipped. Faults that can be mended (vertices
at one place, triangles without area, numbers that are not finite) are mended, counted and reported.)";

void addMesh(const cli::Command& program, CommandLine& line) {
    const auto command =
        program.subcommand("mesh", "Make a dataset of a triangle mesh, or of a surface in a volume");
    const auto job = std::make_shared<AskedJob>();
    auto& mesh = *job->request.mutable_mesh();
    fieldOption(command, mesh, "input", "INPUT").required();
    fieldOption(command, mesh, "isovalue").valueName("V");
    fieldOption(command, mesh, "clip").values(6).valueName("X0 Y0 Z0 X1 Y1 Z1");
    addVolumeOptions(command, *mesh.mutable_source());
    addOutlookOptions(command, job->request);
    addDatasetOptions(command, line, job, [](proto::JobRequest& request) {
        if (request.mesh().source().ByteSizeLong() == 0) request.mutable_mesh()->clear_source();
        return success();
    });
    command.footer(meshExamples);
}

Result<proto::Manifest> runMesh(const Job& job) {
    MOTE_RETURN_IF_ERROR(checkMeshJob(job.request.mesh()), "mesh");
    return runMeshJob(job.request, job.inputs.front(), job.output, job.resources, job.progress);
}

}  // namespace

const JobKind meshJob{proto::JobRequest::kMesh, false, addMesh, runMesh};

}  // namespace mote::prep
