// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "preprocess/command_line.h"

namespace mote::prep {
namespace {

constexpr const char* examples = R"(Examples:
  mote-prep stipple plane --points 50000 --seed 1 --out plane.mote
  mote-prep stipple teapot.obj --points 52000 --seed 1 --out teapot.mote)";

/// As the command line gives it.
struct Options {
    std::string surface;
    std::uint64_t points = 0;
    std::uint64_t seed = 1;
    std::string out;
    std::string title;
    std::optional<std::uint32_t> rings;
    std::optional<double> relaxation;
    ParticlesJobOptions job;
};

proto::JobRequest toRequest(const Options& options) {
    proto::JobRequest request;
    request.set_title(options.title);
    request.set_output(options.out);
    auto& job = *request.mutable_stipple();
    if (options.surface != "plane") job.set_mesh(options.surface);
    job.set_points(options.points);
    job.set_seed(options.seed);
    if (options.rings) job.set_rings(*options.rings);
    if (options.relaxation) job.set_relaxation(*options.relaxation);
    return request;
}

}  // namespace

void addStippleCommand(CLI::App& program, CommandLine& line) {
    auto& command = *program.add_subcommand("stipple", "Make a hierarchy of evenly spread dots");
    const auto options = std::make_shared<Options>();
    command
        .add_option("SURFACE", options->surface,
                    "\"plane\", the periodic unit square, or the file of a triangle mesh")
        ->required();
    command.add_option("--points", options->points, "Points at the highest density")
        ->required()
        ->type_name("N");
    command.add_option("--seed", options->seed, "Of the random start; default 1")->type_name("S");
    command.add_option("--out", options->out, "The dataset to make, which must not exist")
        ->required()
        ->type_name("DIR/NAME.mote");
    command.add_option("--title", options->title, "What viewers call it")->type_name("TEXT");
    command.add_option("--rings", options->rings, "Rings of neighbours that move at a removal; default 2")
        ->type_name("1|2");
    command.add_option("--relaxation", options->relaxation, "Of their moves, 1 to 1.9; default 1.6")
        ->type_name("W");
    addResourceOptions(command, options->job);
    addOutputFlags(command, line);
    command.footer(examples);
    command.callback([options, &line] {
        line.command = [options, &line] { return runAndPrint(line, toRequest(*options), {}, options->job); };
    });
}

}  // namespace mote::prep
