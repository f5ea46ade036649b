// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "preprocess/job_kinds.h"
#include "preprocess/mesh/mesh_job.h"

namespace mote::prep {
namespace {

constexpr const char* examples = R"(Example:
  mote-prep mesh skull.obj --out plots/skull.mote

MESH is OBJ, PLY (ASCII, either byte order, strips), STL or OFF, and may be gzipped. What is wrong with it and can be put
right (vertices at one place, triangles without area, numbers that are not finite) is counted and said.)";

void addCommand(const cli::Command& program, CommandLine& line) {
    const auto command = program.subcommand("mesh", "Make a dataset of a triangle mesh");
    const auto options = std::make_shared<DatasetOptions>();
    command.option("MESH", options->input, "The mesh, a file").required();
    addDatasetOptions(command, line, options,
                      [options](auto& request) { request.mutable_mesh()->set_input(options->input); });
    command.footer(examples);
}

Result<proto::Manifest> run(const Job& job) {
    return runMeshJob(job.request, job.inputs.front(), job.output, job.resources, job.progress);
}

}  // namespace

const JobKind meshJob{proto::JobRequest::kMesh, false, addCommand, run};

}  // namespace mote::prep
