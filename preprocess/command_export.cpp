// SPDX-License-Identifier: GPL-3.0-or-later
//
// mote-prep export: a step's volume, or particles, for other programs.
#include <fmt/format.h>

#include <memory>

#include "preprocess/export/export_job.h"
#include "preprocess/export_vdb.h"
#include "preprocess/job_kinds.h"
#include "protocol/base/json.h"
#include "storage/manifest.h"

namespace mote::prep {
namespace {

constexpr const char* exportExamples = R"(Examples:
  mote-prep export beam.mote --step 3 --vdb beam-3.vdb
  mote-prep export beam.mote --steps 3 --select halo.json --openpmd halo.h5

--vdb: of particles a grid "density"; of a hybrid volume the low-resolution "volume" and the "residual" to add to it.
--openpmd: the particles, in m, eV/c and s, as openPMD-beamphysics HDF5 with ids and weights. A selection is JSON:
docs/SELECTIONS.md.)";

/// The job, and the rest of what is asked for.
struct ExportArguments : AskedJob {
    std::string vdb, select;
    std::uint32_t step = 0;
};

int exportVolume(const CommandLine& line, const ExportArguments& options) {
    const auto& dataset = options.request.export_().dataset();
    const auto manifest = storage::readManifest(dataset);
    if (!manifest.ok()) return fail(line, manifest.error());
    const auto made = exportVdb(dataset, *manifest, options.step, options.vdb);
    if (!made.ok()) return fail(line, made.error());
    if (line.json) {
        JsonObject object;
        fmt::print("{}\n", object.add("output", options.vdb).add("step", options.step).text());
    } else if (!line.quiet) {
        fmt::print("{}: {} of step {}\n", options.vdb, *made, options.step);
    }
    return 0;
}

int runCommand(const CommandLine& line, ExportArguments& options) {
    if (options.vdb.empty() == options.request.output().empty())
        return fail(line, invalid("--vdb", "give either --vdb FILE or --openpmd FILE"));
    if (!options.vdb.empty()) return exportVolume(line, options);
    if (!options.select.empty()) {
        const auto read = readJsonFile(options.select, *options.request.mutable_export_()->mutable_select());
        if (!read.ok()) return fail(line, read.error());
    }
    return runAndPrint(line, options.request, {}, options.resources);
}

void addExport(const cli::Command& program, CommandLine& line) {
    const auto command = program.subcommand("export", "Write a step's volume, or particles, for other tools");
    const auto options = std::make_shared<ExportArguments>();
    auto& job = *options->request.mutable_export_();
    fieldOption(command, job, "dataset", "DATASET").required();
    command.option("--vdb", options->vdb, "The OpenVDB file to make, which must not exist").valueName("FILE");
    command.option("--step", options->step, "--vdb: index of the step").showDefault().valueName("N");
    fieldOption(command, options->request, "output", "--openpmd",
                "The openPMD file to make, which must not exist")
        .valueName("FILE.h5");
    fieldOption(command, job, "steps").valueName("FIRST:LAST:STRIDE");
    command.option("--select", options->select, "--openpmd: these particles; all unless given")
        .valueName("SELECTION.json");
    fieldOption(command, job, "columns").valueName("NAME ...");
    addResourceOptions(command, options->resources);
    addOutputFlags(command, line);
    command.footer(exportExamples);
    command.callback(
        [options, &line] { line.command = [options, &line] { return runCommand(line, *options); }; });
}

Result<proto::Manifest> runExport(const Job& job) {
    MOTE_RETURN_IF_ERROR(
        exportParticles(job.request.export_(), job.inputs.front(), job.output, job.resources, job.progress));
    return proto::Manifest();
}

}  // namespace

const JobKind exportJob{proto::JobRequest::kExport, false, addExport, runExport};

}  // namespace mote::prep
