// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <new>

#include "preprocess/command_line.h"
#include "preprocess/console.h"
#include "preprocess/look/confined_child.h"
#include "preprocess/look/look_at.h"
#include "protocol/scene/complain.h"
#include "protocol/scene/utf8.h"
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
line for each input: {"input", "found": [{"kind", "format", "toldBy", "steps", "columns", "notes", ...}], "refused"}.
The exit status is 1 where something would be refused.)";

constexpr std::uint64_t mostSeconds = 600;  // of the processor, for what is no more than a look

struct LookArguments {
    std::vector<std::string> inputs;
    std::string format, species, map, field, series;
    std::optional<double> mass, frequency, kineticEnergy;
    std::uint64_t memory = 0;
    bool all = false;

    LookOptions looked() const {
        LookOptions made;
        made.all = all;
        made.memory = memory;
        made.particles.set_format(format == "auto" ? "" : format);
        made.particles.set_species(species);
        made.particles.set_map(map);
        if (mass) made.particles.mutable_impact()->set_mass(*mass);
        if (frequency) made.particles.mutable_impact()->set_frequency(*frequency);
        if (kineticEnergy) made.particles.mutable_impact()->set_kinetic_energy(*kineticEnergy);
        made.volume.set_format(format == "auto" ? "" : format);
        made.volume.set_field(field);
        made.volume.set_series(series);
        return made;
    }
};

/// Of an input of which nothing can be said: on stderr, and to scripts.
int refuse(const CommandLine& line, const std::string& input, const Error& error) {
    if (line.json && error.code != ErrorCode::cancelled) {
        Look look;
        look.input = input;
        look.refused.push_back(error.toString());
        std::fputs(jsonLine(look).c_str(), stdout);
    }
    return fail(line, error);
}

/// In the child: looks at one input, and prints what it is.
int lookAndPrint(const CommandLine& line, const LookArguments& options, const std::string& input) {
    const auto look = [&] {
        ConsoleProgress progress(line.signal, {line.quiet, -1});
        return lookAt(input, options.looked(), progress);
    }();
    if (!look.ok()) return refuse(line, input, look.error());
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
        const auto status =
            runConfined([&] { return lookInChild(line, options, input); }, confinement, line.signal);
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
    const auto command = program.subcommand("look", "Say what foreign files hold, and prepare nothing");
    const auto options = std::make_shared<LookArguments>();
    command.option("INPUT", options->inputs, "Files, folders, or names with %T").required();
    command.flag("--all", options->all, "Ranges of all steps, not of the first alone");
    command
        .option("--format", options->format, "As of particles and volume; told by its content unless given")
        .valueName("NAME");
    command.option("--species", options->species, "This openPMD species alone").valueName("NAME");
    command.option("--map", options->map, "What a table's columns are, as of particles").valueName("TEXT");
    command.option("--field", options->field, "This field or volume alone").valueName("NAME");
    command.option("--series", options->series, "This series of DICOM files alone").valueName("NAME");
    command.option("--mass", options->mass, "Rest mass, eV/c^2, where the file does not say it")
        .valueName("EV");
    command.option("--frequency", options->frequency, "IMPACT: scaling frequency, Hz").valueName("HZ");
    command.option("--kinetic-energy", options->kineticEnergy, "IMPACT: reference kinetic energy, eV")
        .valueName("EV");
    command
        .option("--memory", options->memory,
                "Memory that reading may take, as 8G; three quarters of the machine's unless given")
        .size(std::uint64_t{1} << 20, std::uint64_t{1} << 50)
        .valueName("BYTES");
    addOutputFlags(command, line);
    command.footer(lookExamples);
    command.callback([options, &line] { line.command = [options, &line] { return look(line, *options); }; });
}

}  // namespace mote::prep
