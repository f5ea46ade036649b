// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/command_line.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sysexits.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <span>
#include <system_error>
#include <type_traits>

#include "preprocess/job_kinds.h"
#include "preprocess/parallel/communicator.h"
#include "protocol/base/complain.h"
#include "protocol/base/json.h"
#include "protocol/base/utf8.h"
#include "protocol/scene/fields/facts.h"
#include "protocol/scene/job_request.h"
#include "protocol/scene/space/length_unit.h"
#include "storage/dataset_kind.h"

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
    if (request.output().empty()) return invalid("output", "is missing");
    auto path = roots.empty() ? Result<fs::path>(request.output()) : roots.resolveNew(request.output());
    if (!path.ok() && path.error().code == ErrorCode::alreadyExists && appendsSteps(request))
        path = roots.resolveExisting(request.output());
    if (!path.ok()) return inField(path.error(), "output");
    if (served.draft.empty()) return path;
    const auto name = path->filename();
    *path += ".partial-" + served.draft;
    return *path / name;
}

Result<fs::path> inputPath(const JobInput& input, const storage::Roots& roots) {
    if (input.name.empty()) return invalid(input.field, "is missing");
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
        return invalid("", "the request holds no job that this program knows");
    }
    const auto& kind = **found;
    if (!kind.together && resources.ranks && resources.ranks->size() > 1) {
        return unsupported("", "this kind of job runs in one process, not under MPI");
    }
    MOTE_ASSIGN_OR_RETURN(const auto inputs, inputPaths(request, roots));
    MOTE_ASSIGN_OR_RETURN(auto manifest, kind.run({request, inputs, output, resources, progress}));
    return JobOutcome{std::move(output), std::move(manifest)};
}

void printJson(const JobOutcome& outcome, double seconds, JsonObject object) {
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

namespace pb = google::protobuf;

/// A field of a message, or of one within: "impact.mass".
class FieldPlace {
  public:
    FieldPlace(pb::Message& message, const std::string& path) : message_(&message) {
        const auto* type = message.GetDescriptor();
        for (std::size_t begin = 0, end = 0; end < path.size(); begin = end + 1) {
            end = std::min(path.find('.', begin), path.size());
            path_.push_back(type->FindFieldByName(path.substr(begin, end - begin)));
            MOTE_CHECK(path_.back() != nullptr);
            type = path_.back()->message_type();
        }
    }
    const pb::FieldDescriptor& field() const { return *path_.back(); }

    /// Of a number that the message cannot leave unsaid.
    void putDefault() const {
        const auto& usual = factsOf(field()).default_();
        if (usual.empty() || field().has_presence()) return;
        if (field().cpp_type() == pb::FieldDescriptor::CPPTYPE_UINT32)
            put(static_cast<std::uint32_t>(usual[0]), &pb::Reflection::SetUInt32);
        else
            put(static_cast<std::uint64_t>(usual[0]), &pb::Reflection::SetUInt64);
    }

    /// By a member function of Reflection; makes the messages on the way.
    template <class T>
    using Put = void (pb::Reflection::*)(pb::Message*, const pb::FieldDescriptor*, T) const;
    template <class T>
    void put(const T& value, Put<T> how) const {
        auto* message = message_;
        for (const auto* field : std::span(path_).first(path_.size() - 1))
            message = message->GetReflection()->MutableMessage(message, field);
        // A format that is told by the content is none.
        if constexpr (std::is_same_v<T, std::string>)
            if (field().name() == "format" && value == "auto") return;
        (message->GetReflection()->*how)(message, path_.back(), value);
    }
    /// The option that puts it there.
    template <class T>
    cli::Option option(const cli::Command& command, const std::string& name, const std::string& help,
                       Put<T> set, Put<T> add) const {
        if (!field().is_repeated())
            return command.takes<T>(
                name, [=, *this](const T& value) { put(value, set); }, help);
        const auto putAll = [=, *this](const std::vector<T>& values) {
            for (const T& value : values) put(value, add);
        };
        return command.takes<std::vector<T>>(name, putAll, help);
    }

  private:
    pb::Message* message_;
    std::vector<const pb::FieldDescriptor*> path_;
};

cli::Option placeOption(const cli::Command& command, const FieldPlace& place, const std::string& name,
                        const std::string& help) {
    using R = pb::Reflection;
    switch (place.field().cpp_type()) {
        case pb::FieldDescriptor::CPPTYPE_BOOL:
            return command.flag(
                name, [=] { place.put(true, &R::SetBool); }, help);
        case pb::FieldDescriptor::CPPTYPE_UINT32:
            return place.option<std::uint32_t>(command, name, help, &R::SetUInt32, &R::AddUInt32);
        case pb::FieldDescriptor::CPPTYPE_UINT64:
            return place.option<std::uint64_t>(command, name, help, &R::SetUInt64, &R::AddUInt64);
        case pb::FieldDescriptor::CPPTYPE_DOUBLE:
            return place.option<double>(command, name, help, &R::SetDouble, &R::AddDouble);
        default:
            MOTE_CHECK(place.field().cpp_type() == pb::FieldDescriptor::CPPTYPE_STRING);
            return place.option<std::string>(command, name, help, &R::SetString, &R::AddString);
    }
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

cli::Option fieldOption(const cli::Command& command, pb::Message& message, const std::string& field,
                        const std::string& name, const std::string& help) {
    const FieldPlace place(message, field);
    auto known = name.empty() ? "--" + place.field().name() : name;
    if (name.empty()) std::ranges::replace(known, '_', '-');
    place.putDefault();
    const auto option = placeOption(command, place, known, help.empty() ? helpOf(place.field()) : help);
    const auto& words = factsOf(place.field()).one_of();
    return words.empty() ? option : option.oneOf({words.begin(), words.end()});
}

void addProgressOption(const cli::Command& command, int& descriptor) {
    command.option("--progress-fd", descriptor, "Write progress as JSON lines")
        .range(0, 1 << 20)
        .valueName("N");
}

Status checkProgressDescriptor(int descriptor) {
    if (descriptor < 0 || ::fcntl(descriptor, F_GETFD) >= 0) return success();
    return invalid("--progress-fd", "is not an open descriptor");
}

void addResourceOptions(const cli::Command& command, JobResources& resources) {
    command.option("--threads", resources.threads, "Threads; default: as many as there are cores")
        .range(1, 1024)
        .valueName("N");
    command
        .option("--memory", resources.memory,
                "Memory that each process of the job may use, such as 8G; default: three quarters of the "
                "machine's. Beyond it, particles go to a temporary file beside the output")
        .size(std::uint64_t{1} << 20, std::uint64_t{1} << 50)
        .valueName("BYTES");
}

void addOutputOptions(const cli::Command& command, AskedJob& job) {
    fieldOption(command, job.request, "output", "--out").required().valueName("DIR/NAME.mote");
    fieldOption(command, job.request, "title").valueName("TEXT");
}

void addOutlookOptions(const cli::Command& command, proto::JobRequest& request) {
    fieldOption(command, request, "up").valueName("AXIS");
    fieldOption(command, request, "front").valueName("AXIS");
    std::vector<std::string> units;
    units.reserve(ownLengthUnits.size());
    for (const auto& unit : ownLengthUnits) units.emplace_back(unit.name);
    fieldOption(command, request, "unit").oneOf(units).valueName("UNIT");
}

void runWhenChosen(const cli::Command& command, CommandLine& line, const std::shared_ptr<AskedJob>& job,
                   std::function<Status(proto::JobRequest&)> complete) {
    command.callback([job, &line, complete = std::move(complete)] {
        line.command = [job, &line, complete] {
            const auto completed = complete ? complete(job->request) : success();
            return completed.ok() ? runAndPrint(line, job->request, {}, job->resources)
                                  : fail(line, completed.error());
        };
    });
}

void addDatasetOptions(const cli::Command& command, CommandLine& line, const std::shared_ptr<AskedJob>& job,
                       std::function<Status(proto::JobRequest&)> complete) {
    addOutputOptions(command, *job);
    addResourceOptions(command, job->resources);
    addOutputFlags(command, line);
    runWhenChosen(command, line, job, std::move(complete));
}

int runAndPrint(const CommandLine& line, const proto::JobRequest& request, const storage::Roots& roots,
                const JobResources& resources, const ServedJob& served, const JsonObject& said) {
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
        printJson(*outcome, seconds.count(), said);
    } else if (!line.quiet) {
        printText(*outcome, seconds.count());
    }
    return 0;
}

Status writeScript(const proto::Script& script, DraftFile& draft) {
    std::ofstream file(draft.path(), std::ios::binary | std::ios::trunc);
    file << toJson(script);
    file.close();
    if (!file) return Error{ErrorCode::resourceExhausted, draft.path().string(), "cannot be written"};
    return draft.publish();
}

Status mustNotExist(const std::filesystem::path& path) {
    std::error_code code;
    if (!std::filesystem::exists(path, code)) return success();
    return Error{ErrorCode::alreadyExists, path.string(), "exists, and is not replaced"};
}

int fail(const CommandLine& line, const Error& error) {
    if (error.code == ErrorCode::cancelled && line.signal.received() != 0) {
        complain("mote-prep", "cancelled, nothing was made");
        return 128 + line.signal.received();
    }
    complain("mote-prep", error.toString());
    return exitStatus(error);
}

void addVolumeOptions(const cli::Command& command, proto::VolumeSourceOptions& source) {
    const auto field = [&](const char* name) { return fieldOption(command, source, name); };
    field("format").valueName("NAME");
    field("dimensions").values(3).valueName("NX NY NZ");
    field("type").valueName("TYPE");
    field("big_endian");
    field("header_bytes").valueName("N");
    field("spacing").values(3).valueName("SX SY SZ");
    field("origin").values(3).valueName("X Y Z");
    field("field").valueName("NAME");
    field("series").valueName("NAME");
    field("space").valueName("NAME");
}

}  // namespace mote::prep
