// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <memory>
#include <new>

#include "preprocess/auto/choice.h"
#include "preprocess/command_line.h"
#include "preprocess/console.h"
#include "preprocess/look/confined_child.h"
#include "preprocess/look/look_at.h"
#include "protocol/base/complain.h"
#include "protocol/base/utf8.h"
#include "storage/storage_error.h"

namespace mote::prep {
namespace {

constexpr const char* lookExamples = R"(Examples:
  mote-prep look run.h5
  mote-prep look chest.nrrd teapot.obj --json | jq '.found[].format'
  mote-prep look runs/beam_%T.h5 --all
  mote-prep look table.txt --map "x=X [mm],px=PX [MeV/c]"

Each input, be it a file, a folder or a name with %T, is opened as a job would open it, in a process that can write
nothing: what it can be read as, its steps, columns and ranges in the units that a dataset would have, what would be
assumed (note) and what would be refused, and why. Ranges are those of the first step; --all reads all. With --json a
line for each input: {"input", "found": [{"kind", "format", "toldBy", "steps", "lines", "columns", "notes", ...}], "refused"}.
The exit status is 1 if something would be refused.)";

constexpr std::uint64_t mostSeconds = 600;  // of the processor, for what is no more than a look

struct LookArguments : LookOptions {
    std::vector<std::string> inputs;
    bool confined = false;
};

/// Tells, on stderr and to scripts, why nothing can be said of an input.
int refuse(const CommandLine& line, const std::string& input, const Error& error) {
    if (line.json && error.code != ErrorCode::cancelled) {
        Look look;
        look.input = input;
        look.refused.push_back(error.toString());
        std::fputs(jsonLine(look).c_str(), stdout);
    }
    return fail(line, error);
}

/// Says along which axes a run is plotted where nobody says others.
void addAxes(Look& look) {
    for (Found& found : look.found) {
        if (found.kind != "particles" || !found.refused.empty()) continue;
        const auto chosen = chooseAxes(found);
        auto axes = fmt::format("{}", fmt::join(chosen.axes, ","));
        found.facts.push_back(
            {"axes", axes, "axes", fmt::format("{}, unless others are said: {}", axes, chosen.why)});
    }
}

/// Looks at one input, in the child, and prints what it is.
int lookAndPrint(const CommandLine& line, const LookArguments& options, const std::string& input) {
    auto look = [&] {
        ConsoleProgress progress(line.signal, {line.quiet, -1});
        return lookAt(input, options, progress);
    }();
    if (!look.ok()) return refuse(line, input, look.error());
    addAxes(*look);
    const std::string text = line.json ? jsonLine(*look) : toTerminalLines(lookText(*look));
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
        return fail(line, {ErrorCode::internal, "stdout", "cannot be written to any more"});
    return look->whole() ? 0 : 1;
}

int lookInChild(const CommandLine& line, const LookArguments& options, const std::string& input) {
    try {
        return lookAndPrint(line, options, input);
    } catch (const storage::StorageError& error) {
        return refuse(line, input, error.error());
    } catch (const std::bad_alloc&) {
        return refuse(line, input,
                      {ErrorCode::resourceExhausted, input, "takes more memory to be read than there is"});
    } catch (const std::exception& error) {
        return refuse(line, input, {ErrorCode::internal, input, error.what()});
    }
}

int look(const CommandLine& line, const LookArguments& options) {
    int worst = 0;
    const Confinement confinement{options.memory, options.all ? 0 : mostSeconds};
    for (const std::string& input : options.inputs) {
        const auto work = [&] { return lookInChild(line, options, input); };
        const auto status =
            options.confined ? Result<int>(work()) : runConfined(work, confinement, line.signal);
        if (line.signal.received() != 0) return 128 + line.signal.received();
        if (status.ok()) {
            worst = std::max(worst, *status);
            continue;
        }
        auto error = status.error();
        error.where = input;
        worst = std::max(worst, refuse(line, input, error));
    }
    return worst;
}

}  // namespace

void addLookCommand(const cli::Command& program, CommandLine& line) {
    const auto command = program.subcommand("look", "Say what files hold, and prepare nothing");
    const auto options = std::make_shared<LookArguments>();
    command.option("INPUT", options->inputs, "Files, folders, or names with %T").required();
    command.flag("--all", options->all, "Ranges over all steps, not only the first");
    command.flag("--confined", options->confined,
                 "This process is confined already, as jobs of a server are: make no other to read in");
    const auto takeFormat = [found = options.get()](const std::string& name) {
        if (name == "auto") return;
        found->particles.set_format(name);
        found->volume.set_format(name);
    };
    command
        .takes<std::string>("--format", takeFormat,
                            "As for particles and volume; default: told by its content")
        .valueName("NAME");
    auto& run = options->particles;
    auto& volume = options->volume;
    fieldOption(command, run, "species", {}, "Only this openPMD species").valueName("NAME");
    fieldOption(command, run, "map", {}, "What a table's columns are, as for particles").valueName("TEXT");
    fieldOption(command, volume, "field", {}, "Only this field or volume").valueName("NAME");
    fieldOption(command, volume, "series", {}, "Only this series of DICOM files").valueName("NAME");
    fieldOption(command, run, "impact.mass", {}, "Rest mass, eV/c^2, where the file does not say it")
        .valueName("EV");
    fieldOption(command, run, "impact.frequency", {}, "IMPACT: scaling frequency, Hz").valueName("HZ");
    fieldOption(command, run, "impact.kinetic_energy", {}, "IMPACT: reference kinetic energy, eV")
        .valueName("EV");
    command
        .option("--memory", options->memory,
                "Memory that reading may use, such as 8G; default: three quarters of the machine's")
        .size(std::uint64_t{1} << 20, std::uint64_t{1} << 50)
        .valueName("BYTES");
    addOutputFlags(command, line);
    command.footer(lookExamples);
    command.callback([options, &line] { line.command = [options, &line] { return look(line, *options); }; });
}

}  // namespace mote::prep
