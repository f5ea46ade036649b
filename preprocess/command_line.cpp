// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/command_line.h"

#include <fmt/format.h>
#include <sysexits.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "preprocess/console.h"
#include "preprocess/job.h"
#include "preprocess/job_kinds.h"
#include "preprocess/parallel/communicator.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/complain.h"
#include "protocol/scene/job_request.h"
#include "protocol/scene/utf8.h"
#include "storage/dataset_kind.h"
#include "storage/roots.h"

namespace mote::prep {
namespace {

struct JobOutcome {
    std::filesystem::path output;  ///< the dataset or file
    proto::Manifest manifest;      ///< of a dataset; without a kind of anything else
};

namespace fs = std::filesystem;

int exitStatus(const Error& error) {
    if (error.passing) return EX_TEMPFAIL;
    return error.code == ErrorCode::invalidArgument ? 2 : 1;
}

/// "FIELD (NAME): sentence", keeping what kind of error it is.
Error inField(const Error& error, std::string_view field) {
    return {error.code, error.where.empty() ? std::string(field) : fmt::format("{} ({})", field, error.where),
            error.message, error.passing};
}

Result<fs::path> outputPath(const proto::JobRequest& request, const storage::Roots& roots,
                            const ServedJob& served) {
    if (request.output().empty() && !served.output.empty()) return served.output;
    if (request.output().empty()) return Error{ErrorCode::invalidArgument, "output", "is missing"};
    auto path = roots.empty() ? Result<fs::path>(request.output()) : roots.resolveNew(request.output());
    if (!path.ok()) return inField(path.error(), "output");
    if (served.draft.empty()) return path;
    const auto name = path->filename();
    *path += ".partial-" + served.draft;
    return *path / name;
}

Result<fs::path> inputPath(const JobInput& input, const storage::Roots& roots) {
    if (input.name.empty()) return Error{ErrorCode::invalidArgument, input.field, "is missing"};
    if (roots.empty()) return fs::path(input.name);
    auto path = roots.resolveExisting(input.name);
    return path.ok() ? path : inField(path.error(), input.field);
}

Result<std::vector<fs::path>> inputPaths(const proto::JobRequest& request, const storage::Roots& roots) {
    std::vector<fs::path> paths;
    for (const auto& input : jobInputs(request)) {
        MOTE_ASSIGN_OR_RETURN(auto path, inputPath(input, roots));
        paths.push_back(std::move(path));
    }
    return paths;
}

/// With roots, inputs and output are "ROOT/PATH" beneath them; without, paths. Errors: invalidArgument with
/// the field's path, and the job's own.
Result<JobOutcome> runJob(const proto::JobRequest& request, const storage::Roots& roots,
                          const ServedJob& served, const JobResources& resources, Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(auto output, outputPath(request, roots, served));
    const auto found =
        std::ranges::find(jobKinds, request.kind_case(), [](const auto* kind) { return kind->kind; });
    if (found == jobKinds.end()) {
        return Error{ErrorCode::invalidArgument, "", "the request holds no job that this program knows"};
    }
    const auto& kind = **found;
    if (!kind.together && resources.ranks && resources.ranks->size() > 1) {
        return Error{ErrorCode::unsupported, "", "this kind of job runs in one process, not under MPI"};
    }
    MOTE_ASSIGN_OR_RETURN(const auto inputs, inputPaths(request, roots));
    MOTE_ASSIGN_OR_RETURN(auto manifest, kind.run({request, inputs, output, resources, progress}));
    return JobOutcome{std::move(output), std::move(manifest)};
}

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
    fmt::print("{}: {}made in {:.1f} s\n", toTerminalText(outcome.output.string()), toTerminalText(made),
               seconds);
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
                const JobResources& resources, const ServedJob& served) {
    const auto begin = std::chrono::steady_clock::now();
    auto ranks = joinRanks(line.signal);
    if (!ranks.ok()) return fail(line, ranks.error());
    const bool first = (*ranks)->first();
    auto outcome = [&] {
        ConsoleProgress progress(line.signal, {line.quiet || !first, first ? served.progressDescriptor : -1});
        auto together = resources;
        together.ranks = ranks->get();
        return runJob(request, roots, served, together, progress);
    }();
    // What all ranks know, one says.
    if (!first) return outcome.ok() ? 0 : exitStatus(outcome.error());
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
        complain("mote-prep", "cancelled, nothing was made");
        return 128 + line.signal.received();
    }
    complain("mote-prep", error.toString());
    return exitStatus(error);
}

void addVolumeOptions(const cli::Command& command, VolumeOptions& options) {
    command.option("--format", options.format, "A volume's format; told by its content unless given")
        .valueName("NAME");
    command.option("--dimensions", options.dimensions, "Raw: voxels along x, y, z")
        .values(3)
        .valueName("NX NY NZ");
    command.option("--type", options.type, "Raw: u8 (the default), i8, u16, i16, u32, i32, f16, f32 or f64")
        .valueName("TYPE");
    command.flag("--big-endian", options.bigEndian, "Raw: the most significant byte comes first");
    command.option("--header-bytes", options.headerBytes, "Raw: before the first value").valueName("N");
    command.option("--spacing", options.spacing, "Of voxels, instead of what the file says")
        .values(3)
        .valueName("SX SY SZ");
    command.option("--origin", options.origin, "World position of the first voxel's centre")
        .values(3)
        .valueName("X Y Z");
    command
        .option("--field", options.field,
                "VTI array, OpenVDB grid, NumPy array, channel, or number of one of several volumes")
        .valueName("NAME");
    command.option("--series", options.series, "DICOM: the number or UID of one of several series")
        .valueName("NAME");
    command
        .option("--space", options.space,
                "Where patients lie: ras (the default), lps, or file: as the file has it")
        .valueName("NAME");
}

proto::VolumeSourceOptions VolumeOptions::message() const {
    proto::VolumeSourceOptions source;
    source.set_format(format == "auto" ? "" : format);
    source.mutable_dimensions()->Assign(dimensions.begin(), dimensions.end());
    source.set_type(type);
    source.set_big_endian(bigEndian);
    source.set_header_bytes(headerBytes);
    source.mutable_spacing()->Assign(spacing.begin(), spacing.end());
    source.mutable_origin()->Assign(origin.begin(), origin.end());
    source.set_field(field);
    source.set_space(space);
    source.set_series(series);
    return source;
}

}  // namespace mote::prep
