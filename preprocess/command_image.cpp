// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>
#include <memory>

#include "preprocess/command_line.h"

namespace mote::prep {
namespace {

constexpr const char* examples = R"(Examples:
  mote-prep image lighthouse.png --out plots/lighthouse.mote

FILE is PNG, JPEG, TIFF or OpenEXR, of 8 or 16 bits or floats, grey or in colour. What is kept is its linear
luminance (ITU-R BT.709), upright, and laid on white where it is transparent. Integers are taken as sRGB and floats as
linear, unless the file says something else.)";

struct Options {
    std::string input;
    std::string out;
    std::string title;
    ParticlesJobOptions job;
};

}  // namespace

void addImageCommand(CLI::App& program, CommandLine& line) {
    auto& command = *program.add_subcommand("image", "Make an image dataset, for stippled photographs");
    const auto options = std::make_shared<Options>();
    command.add_option("FILE", options->input, "The picture")->required();
    command.add_option("--out", options->out, "The dataset to make, which must not exist")
        ->required()
        ->type_name("DIR/NAME.mote");
    command.add_option("--title", options->title, "What viewers call it")->type_name("TEXT");
    addResourceOptions(command, options->job);
    addOutputFlags(command, line);
    command.footer(examples);
    command.callback([options, &line] {
        line.command = [options, &line] {
            proto::JobRequest request;
            request.set_title(options->title);
            request.set_output(options->out);
            request.mutable_image()->set_input(options->input);
            return runAndPrint(line, request, {}, options->job);
        };
    });
}

}  // namespace mote::prep
