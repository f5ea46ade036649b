// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <memory>

#include "preprocess/command_line.h"
#include "protocol/scene/json.h"
#include "storage/dataset_kind.h"
#include "storage/manifest.h"

namespace mote::prep {
namespace {

void printText(const proto::Manifest& manifest) {
    fmt::print("title    {}\nkind     {}\nwriter   {}\n{}", manifest.title(), manifest.kind(),
               manifest.writer(), storage::findKind(manifest)->describe(manifest));
}

int run(const CommandLine& line, const std::string& directory) {
    const auto manifest = storage::readManifest(directory);
    if (!manifest.ok()) return fail(line, manifest.error());
    if (line.json) {
        fmt::print("{}", toJson(*manifest));
    } else {
        printText(*manifest);
    }
    return 0;
}

}  // namespace

void addInfoCommand(const cli::Command& program, CommandLine& line) {
    const auto command = program.subcommand("info", "Say what a dataset holds");
    const auto directory = std::make_shared<std::string>();
    command.option("DATASET", *directory, "NAME.mote").required();
    addOutputFlags(command, line);
    command.footer(
        "Examples:\n  mote-prep info beam.mote\n  mote-prep info beam.mote --json | jq .particles.axes");
    command.callback(
        [directory, &line] { line.command = [directory, &line] { return run(line, *directory); }; });
}

}  // namespace mote::prep
