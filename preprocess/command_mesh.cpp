// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <memory>

#include "preprocess/command_line.h"

namespace mote::prep {
namespace {

constexpr const char* examples = R"(Example:
  mote-prep mesh skull.obj --out plots/skull.mote

MESH is OBJ, PLY (ASCII, either byte order, strips), STL or OFF, and may be gzipped. What is wrong with it and can be put
right (vertices at one place, triangles without area, numbers that are not finite) is counted and said.)";

struct Options {
    std::string input;
    std::string out;
    std::string title;
    ParticlesJobOptions job;
};

proto::JobRequest toRequest(const Options& options) {
    proto::JobRequest request;
    request.set_title(options.title);
    request.set_output(options.out);
    request.mutable_mesh()->set_input(options.input);
    return request;
}

}  // namespace

void addMeshCommand(CLI::App& program, CommandLine& line) {
    auto& command = *program.add_subcommand("mesh", "Make a dataset of a triangle mesh");
    const auto options = std::make_shared<Options>();
    command.add_option("MESH", options->input, "The mesh, a file")->required();
    command.add_option("--out", options->out, "The dataset to make, which must not exist")
        ->required()
        ->type_name("DIR/NAME.mote");
    command.add_option("--title", options->title, "What viewers call it")->type_name("TEXT");
    addResourceOptions(command, options->job);
    addOutputFlags(command, line);
    command.footer(examples);
    command.callback([options, &line] {
        line.command = [options, &line] { return runAndPrint(line, toRequest(*options), {}, options->job); };
    });
}

}  // namespace mote::prep
