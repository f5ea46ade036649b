// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <memory>

#include "preprocess/command_line.h"
#include "preprocess/console.h"
#include "storage/verify.h"

namespace mote::prep {
namespace {

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

int run(const CommandLine& line, const std::string& directory) {
    const auto errors = [&] {
        ConsoleProgress progress(line.signal, {line.quiet, -1});
        return storage::verifyDataset(
            directory, [&] { return progress.cancelled(); },
            [&](double done) { progress.report(done, "verifying"); });
    }();
    if (errors.size() == 1 && errors.front().code == ErrorCode::cancelled) return fail(line, errors.front());
    for (const auto& error : errors) fmt::print(stderr, "mote-prep: {}\n", error.toString());
    if (line.json) printJson(directory, errors);
    if (errors.empty() && !line.json && !line.quiet) fmt::print("{}: whole\n", directory);
    return errors.empty() ? 0 : 1;
}

}  // namespace

void addVerifyCommand(const cli::Command& program, CommandLine& line) {
    const auto command = program.subcommand("verify", "Check every byte of a dataset");
    const auto directory = std::make_shared<std::string>();
    command.option("DATASET", *directory, "NAME.mote").required();
    addOutputFlags(command, line);
    command.footer("Example:\n  mote-prep verify beam.mote && echo whole");
    command.callback(
        [directory, &line] { line.command = [directory, &line] { return run(line, *directory); }; });
}

}  // namespace mote::prep
