// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/command_line.h"

#include <fmt/format.h>

#include <chrono>

#include "preprocess/console_progress.h"
#include "preprocess/json_object.h"
#include "preprocess/parallel/mpi_communicator.h"
#include "storage/dataset_kind.h"

namespace mote::prep {
namespace {

void printJson(const JobOutcome& outcome, double seconds) {
    JsonObject object;
    object.add("output", outcome.output.string()).add("seconds", seconds);
    if (const auto* kind = storage::findKind(outcome.manifest)) {
        object.add("kind", kind->name);
        for (const auto& [name, number] : kind->summarize(outcome.manifest).numbers) {
            std::visit([&, &name = name](auto value) { object.add(name, value); }, number);
        }
    }
    fmt::print("{}\n", object.text());
}

void printText(const JobOutcome& outcome, double seconds) {
    const auto* kind = storage::findKind(outcome.manifest);
    const auto made = kind ? kind->summarize(outcome.manifest).text + ", " : std::string();
    fmt::print("{}: {}made in {:.1f} s\n", outcome.output.string(), made, seconds);
}

/// The processes of this job: those that a launcher of MPI started, else this one.
Result<std::unique_ptr<Communicator>> joinRanks(const CancelSignal& signal) {
    if (!startedByMpi()) return singleProcess();
    return joinMpi([&signal] { return signal.received() != 0; });
}

}  // namespace

void addOutputFlags(const cli::Command& command, CommandLine& line) {
    command.flag("--json", line.json, "Print one JSON object on stdout");
    command.flag("--quiet", line.quiet, "Print errors only");
}

void addResourceOptions(const cli::Command& command, JobResources& resources) {
    command.option("--threads", resources.threads, "Threads; as many as there are cores unless given")
        .range(1, 1024)
        .valueName("N");
    command
        .option("--memory", resources.memory,
                "Memory that each process of the job may take, as 8G; three quarters of the machine's "
                "unless given. Beyond it, particles lie in a temporary file beside the output")
        .size(std::uint64_t{1} << 20, std::uint64_t{1} << 50)
        .valueName("BYTES");
}

void addDatasetOptions(const cli::Command& command, CommandLine& line,
                       const std::shared_ptr<DatasetOptions>& options,
                       std::function<void(proto::JobRequest&)> complete) {
    command.option("--out", options->out, "The dataset to make, which must not exist")
        .required()
        .valueName("DIR/NAME.mote");
    command.option("--title", options->title, "What viewers call it").valueName("TEXT");
    addResourceOptions(command, options->resources);
    addOutputFlags(command, line);
    command.callback([options, &line, complete = std::move(complete)] {
        line.command = [options, &line, complete] {
            proto::JobRequest request;
            request.set_title(options->title);
            request.set_output(options->out);
            complete(request);
            return runAndPrint(line, request, {}, options->resources);
        };
    });
}

int runAndPrint(const CommandLine& line, const proto::JobRequest& request, const storage::Roots& roots,
                const JobResources& resources, int progressDescriptor) {
    const auto begin = std::chrono::steady_clock::now();
    auto ranks = joinRanks(line.signal);
    if (!ranks.ok()) return fail(line, ranks.error());
    const bool first = (*ranks)->first();
    auto outcome = [&] {
        ConsoleProgress progress(line.signal, {line.quiet || !first, first ? progressDescriptor : -1});
        auto together = resources;
        together.ranks = ranks->get();
        return runJob(request, roots, together, progress);
    }();
    // What all ranks know, one says.
    if (!first) return outcome.ok() ? 0 : 1;
    if (!outcome.ok()) return fail(line, outcome.error());
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    if (line.json) {
        printJson(*outcome, seconds.count());
    } else if (!line.quiet) {
        printText(*outcome, seconds.count());
    }
    return 0;
}

int fail(const CommandLine& line, const Error& error) {
    if (error.code == ErrorCode::cancelled && line.signal.received() != 0) {
        fmt::print(stderr, "mote-prep: cancelled, nothing was made\n");
        return 128 + line.signal.received();
    }
    fmt::print(stderr, "mote-prep: {}\n", error.toString());
    return error.code == ErrorCode::invalidArgument ? 2 : 1;
}

}  // namespace mote::prep
