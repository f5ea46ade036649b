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

INPUT is OBJ, PLY (ASCII, either byte order, strips), STL or OFF, and may be gzipped. What is wrong with it and can be put
right (vertices at one place, triangles without area, numbers that are not finite) is counted and said.)";

/// Options as the command line gives them.
struct MeshArguments : DatasetOptions {
    std::optional<double> isovalue;
    std::vector<double> clip;
    VolumeOptions source;
};

void complete(const MeshArguments& options, proto::MeshJob& job) {
    job.set_input(options.input);
    if (options.isovalue) job.set_isovalue(*options.isovalue);
    job.mutable_clip()->Assign(options.clip.begin(), options.clip.end());
    const auto source = options.source.message();
    if (source.ByteSizeLong() > 0) *job.mutable_source() = source;
}

void addMesh(const cli::Command& program, CommandLine& line) {
    const auto command =
        program.subcommand("mesh", "Make a dataset of a triangle mesh, or of a surface in a volume");
    const auto options = std::make_shared<MeshArguments>();
    command.option("INPUT", options->input, "The mesh or volume, a file or a folder (DICOM, pictures)")
        .required();
    command.option("--isovalue", options->isovalue, "The surface on which a volume has this value")
        .valueName("V");
    command.option("--clip", options->clip, "Keep of that surface what lies in a box, world units")
        .values(6)
        .valueName("X0 Y0 Z0 X1 Y1 Z1");
    addVolumeOptions(command, options->source);
    addDatasetOptions(command, line, options,
                      [options](auto& request) { complete(*options, *request.mutable_mesh()); });
    command.footer(meshExamples);
}

Result<proto::Manifest> runMesh(const Job& job) {
    MOTE_RETURN_IF_ERROR(checkMeshJob(job.request.mesh()), "mesh");
    return runMeshJob(job.request, job.inputs.front(), job.output, job.resources, job.progress);
}

}  // namespace

const JobKind meshJob{proto::JobRequest::kMesh, false, addMesh, runMesh};

}  // namespace mote::prep
