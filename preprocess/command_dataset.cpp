// SPDX-License-Identifier: GPL-3.0-or-later
//
// The subcommands about a dataset that is there: info and verify.
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "preprocess/command_line.h"
#include "preprocess/console.h"
#include "protocol/base/complain.h"
#include "protocol/base/json.h"
#include "protocol/base/utf8.h"
#include "storage/dataset_kind.h"
#include "storage/manifest.h"
#include "storage/verify.h"

namespace mote::prep {
namespace {

/// A subcommand's arguments, of which all have the first.
struct CheckArguments {
    std::string dataset;
};

/// Errors: invalidArgument if what is named is there and is no dataset.
Status mustBeDataset(const std::string& named) {
    const std::filesystem::path path(named);
    std::error_code code;
    if (!std::filesystem::exists(path, code) || std::filesystem::exists(path / storage::manifestName, code) ||
        path.extension() == storage::datasetSuffix)
        return success();
    return unsupported(named,
                       "is no dataset, which is a folder NAME.mote; what a file or another folder "
                       "holds says mote-prep look");
}

int info(const CommandLine& line, const CheckArguments& options) {
    const Status dataset = mustBeDataset(options.dataset);
    if (!dataset.ok()) return fail(line, dataset.error());
    const auto manifest = storage::readManifest(options.dataset);
    if (!manifest.ok()) return fail(line, manifest.error());
    if (line.json) {
        fmt::print("{}", toJson(*manifest));
    } else {
        fmt::print("title    {}\nkind     {}\nwriter   {}\n{}", toTerminalText(manifest->title()),
                   toTerminalText(manifest->kind()), toTerminalText(manifest->writer()),
                   toTerminalLines(storage::findKind(*manifest)->describe(*manifest)));
    }
    return 0;
}

void printJson(const std::string& directory, const std::vector<Error>& errors) {
    std::vector<JsonObject> list;
    for (const auto& error : errors) {
        list.emplace_back()
            .add("code", name(error.code))
            .add("where", error.where)
            .add("message", error.message);
    }
    JsonObject object;
    object.add("dataset", directory).add("whole", errors.empty()).add("errors", list);
    fmt::print("{}\n", object.text());
}

int verify(const CommandLine& line, const CheckArguments& options) {
    const Status dataset = mustBeDataset(options.dataset);
    if (!dataset.ok()) return fail(line, dataset.error());
    const auto errors = [&] {
        ConsoleProgress progress(line.signal, {line.quiet, -1});
        return storage::verifyDataset(
            options.dataset, [&] { return progress.cancelled(); },
            [&](double done) { progress.report(done, "verifying"); });
    }();
    if (errors.size() == 1 && errors.front().code == ErrorCode::cancelled) return fail(line, errors.front());
    for (const auto& error : errors) complain("mote-prep", error.toString());
    if (line.json) printJson(options.dataset, errors);
    if (errors.empty() && !line.json && !line.quiet) fmt::print("{}: whole\n", options.dataset);
    return errors.empty() ? 0 : 1;
}

/// Adds what all have: the dataset, the flags, `examples`, and that the command runs `run`.
void addDatasetCommand(const cli::Command& command, CommandLine& line,
                       const std::shared_ptr<CheckArguments>& options, const char* examples,
                       int (*run)(const CommandLine&, const CheckArguments&)) {
    command.option("DATASET", options->dataset, "NAME.mote").required();
    addOutputFlags(command, line);
    command.footer(examples);
    command.callback(
        [options, &line, run] { line.command = [options, &line, run] { return run(line, *options); }; });
}

}  // namespace

void addInfoCommand(const cli::Command& program, CommandLine& line) {
    addDatasetCommand(
        program.subcommand("info", "Say what a dataset holds"), line, std::make_shared<CheckArguments>(),
        "Examples:\n  mote-prep info beam.mote\n  mote-prep info beam.mote --json | jq .particles.axes",
        info);
}

void addVerifyCommand(const cli::Command& program, CommandLine& line) {
    addDatasetCommand(program.subcommand("verify", "Check every byte of a dataset"), line,
                      std::make_shared<CheckArguments>(),
                      "Example:\n  mote-prep verify beam.mote && echo whole", verify);
}

}  // namespace mote::prep
