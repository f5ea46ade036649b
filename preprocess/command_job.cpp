// SPDX-License-Identifier: GPL-3.0-or-later

#include <memory>

#include "preprocess/command_line.h"
#include "protocol/base/json.h"

namespace mote::prep {
namespace {

constexpr const char* jobExamples = R"(Example:
  mote-prep job request.json --root data=/scratch/runs --progress-fd 3

REQUEST.json is a JobRequest: {"output": "data/beam.mote", "particles": {"inputs": ["data/run.h5"],
"axes": ["x", "px", "y"]}}. With --root, inputs and output are named ROOT/PATH and lie beneath these roots; without,
they are paths. Each change of progress is one line {"progress": 0.25, "phase": "..."} on the descriptor.)";

struct JobArguments {
    std::string request;
    std::vector<std::string> roots;
    int progressDescriptor = -1;
    std::string output, draft;
    JobResources resources;
};

int runJob(const CommandLine& line, const JobArguments& options) {
    const auto progress = checkProgressDescriptor(options.progressDescriptor);
    if (!progress.ok()) return fail(line, progress.error());
    const auto roots = storage::Roots::parse(options.roots);
    if (!roots.ok()) return fail(line, roots.error());
    proto::JobRequest request;
    const auto read = readJsonFile(options.request, request);
    if (!read.ok()) return fail(line, read.error());
    return runAndPrint(line, request, *roots, options.resources,
                       {options.progressDescriptor, options.output, options.draft});
}

}  // namespace

void addJobCommand(const cli::Command& program, CommandLine& line) {
    const auto command = program.subcommand("job", "Run a job request");
    const auto options = std::make_shared<JobArguments>();
    command.option("REQUEST", options->request, "The request, a JSON file").required();
    command.option("--root", options->roots, "A folder that names may begin with; may be repeated")
        .repeatable()
        .valueName("NAME=DIR");
    addProgressOption(command, options->progressDescriptor);
    command
        .option("--output", options->output, "The file to make, of a request that has no output: an export")
        .valueName("FILE");
    command
        .option("--draft", options->draft,
                "Make the output as OUTPUT.partial-ID/NAME, for who then puts it in place")
        .valueName("ID");
    addResourceOptions(command, options->resources);
    addOutputFlags(command, line);
    command.footer(jobExamples);
    command.callback(
        [options, &line] { line.command = [options, &line] { return runJob(line, *options); }; });
}

}  // namespace mote::prep
