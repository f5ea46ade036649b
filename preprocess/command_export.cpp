// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <memory>

#include "preprocess/command_line.h"
#include "preprocess/console.h"
#include "preprocess/export_vdb.h"
#include "storage/manifest.h"

namespace mote::prep {
namespace {

struct Options {
    std::string dataset;
    std::string file;
    std::uint32_t step = 0;
};

int run(const CommandLine& line, const Options& options) {
    const auto manifest = storage::readManifest(options.dataset);
    if (!manifest.ok()) return fail(line, manifest.error());
    const auto made = exportVdb(options.dataset, *manifest, options.step, options.file);
    if (!made.ok()) return fail(line, made.error());
    if (line.json) {
        JsonObject object;
        fmt::print("{}\n", object.add("output", options.file).add("step", options.step).text());
    } else if (!line.quiet) {
        fmt::print("{}: {} of step {}\n", options.file, *made, options.step);
    }
    return 0;
}

}  // namespace

void addExportCommand(const cli::Command& program, CommandLine& line) {
    const auto command = program.subcommand("export", "Write a step's volume for other tools");
    const auto options = std::make_shared<Options>();
    command.option("DATASET", options->dataset, "NAME.mote").required();
    command.option("--vdb", options->file, "The OpenVDB file to make, which must not exist")
        .required()
        .valueName("FILE");
    command.option("--step", options->step, "Index of the step").showDefault().valueName("N");
    addOutputFlags(command, line);
    command.footer(
        "Example:\n  mote-prep export beam.mote --step 3 --vdb beam-3.vdb\n\nOf particles: a grid "
        "\"density\". Of a "
        "hybrid volume: the low-resolution \"volume\" and the \"residual\" to add to it.");
    command.callback([options, &line] { line.command = [options, &line] { return run(line, *options); }; });
}

}  // namespace mote::prep
