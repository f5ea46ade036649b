// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/stats/asked_run.h"

#include <fmt/format.h>
#include <algorithm>
#include <bit>
#include <deque>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "client/shared/film_download.h"
#include "client/shared/jobs.h"
#include "client/shared/numbers.h"
#include "client/shared/part_file.h"
#include "client/stats/npy.h"
#include "protocol/scene/json.h"
#include "protocol/scene/selection.h"
#include "protocol/scene/step_range.h"

namespace mote::client {
namespace {

Result<proto::Selection> readSelection(const std::filesystem::path& file) {
    proto::Selection selection;
    MOTE_RETURN_IF_ERROR(readJsonFile(file, selection));
    const auto parsed = parseSelection(selection);
    if (parsed.ok()) return selection;
    const auto& error = parsed.error();
    return Error{error.code,
                 error.where.empty() ? file.string() : fmt::format("{}: {}", file.string(), error.where),
                 error.message};
}

}  // namespace

Result<AskedRun> AskedRun::open(const StatsOptions& options, ServerLine& server) {
    AskedRun run(server, options.dataset);
    if (!options.select.empty()) {
        MOTE_ASSIGN_OR_RETURN(run.selection_, readSelection(options.select));
    }
    MOTE_RETURN_IF_ERROR(server.waitUntilConnected());
    MOTE_ASSIGN_OR_RETURN(auto description, server.answerTo<proto::Description>([&](auto reply) {
        server.line().describe(options.dataset, std::move(reply));
    }));
    auto& manifest = *description.mutable_manifest();
    if (manifest.kind() != "particles") {
        return Error{ErrorCode::unsupported, options.dataset,
                     fmt::format("holds no particles: it is of kind \"{}\"", manifest.kind())};
    }
    run.manifest_ = std::move(*manifest.mutable_particles());
    auto steps = selectSteps(options.steps, static_cast<std::size_t>(run.manifest_.steps_size()));
    if (!steps.ok()) return Error{steps.error().code, "--steps", steps.error().message};
    run.steps_ = *std::move(steps);
    return run;
}

std::string AskedRun::stepsText() const {
    const auto stride = steps_.size() > 1 ? steps_[1] - steps_[0] : 1;
    return fmt::format("{}:{}:{}", steps_.front(), steps_.back(), stride);
}

proto::Query AskedRun::query() const {
    proto::Query query;
    query.set_dataset(dataset_);
    query.set_steps(stepsText());
    if (selection_) *query.mutable_select() = *selection_;
    return query;
}

Status AskedRun::ask(const proto::Query& query, const std::vector<std::size_t>& steps,
                     const std::function<Status(const QueryAnswer&)>& take) {
    // Shared with the line, which may hold a reply longer than this function runs.
    const auto answers = std::make_shared<std::deque<Result<QueryAnswer>>>();
    const auto request = server_->line().query(
        query, [answers](Result<QueryAnswer> answer) { answers->push_back(std::move(answer)); });
    const auto told = [&]() -> Status {
        for (std::size_t i = 0; i < steps.size(); ++i) {
            MOTE_RETURN_IF_ERROR(server_->waitUntil([&] { return !answers->empty(); }));
            const auto answer = std::move(answers->front());
            answers->pop_front();
            if (!answer.ok()) return answer.error();
            if (answer->message.step() != steps[i] || answer->message.last() != (i + 1 == steps.size()))
                return Error{ErrorCode::corrupt, "",
                             "the server answered for other steps than it was asked for"};
            MOTE_RETURN_IF_ERROR(take(*answer));
        }
        return success();
    }();
    if (told.ok()) return told;
    server_->line().cancelQuery(request);
    server_->farewell();
    return told;
}

namespace {

/// Where rows go. One owner.
class RowFile {
  public:
    virtual ~RowFile() = default;
    /// The rows of a piece. Errors: those of the system.
    virtual Status append(const StepColumns& piece) = 0;
    virtual Status publish() = 0;
};

/// What each row holds.
struct RowShape {
    bool step = false;  ///< first of all, where there are several
    std::vector<std::string> names;
    std::vector<std::string> headings;  ///< by name, with its unit: "x [m]"

    bool isId(std::size_t column) const { return names[column] == "id"; }
};

class NpyRowFile final : public RowFile {
  public:
    static Result<std::unique_ptr<RowFile>> create(const std::filesystem::path& path, const RowShape& shape) {
        std::vector<NpyField> fields;
        if (shape.step) fields.push_back({"step", "<u8"});
        for (std::size_t i = 0; i < shape.names.size(); ++i) {
            const bool titled = shape.headings[i] != shape.names[i];
            fields.push_back(
                {shape.names[i], shape.isId(i) ? "<u8" : "<f8", titled ? shape.headings[i] : ""});
        }
        MOTE_ASSIGN_OR_RETURN(auto rows, NpyRows::create(path, fields));
        return std::unique_ptr<RowFile>(new NpyRowFile(std::move(rows), shape.step));
    }

    Status append(const StepColumns& piece) override {
        std::vector<std::uint64_t> words;
        words.reserve(piece.count * (piece.words.size() + 1));
        for (std::uint64_t row = 0; row < piece.count; ++row) {
            if (step_) words.push_back(piece.step);
            for (const auto& column : piece.words) words.push_back(column[row]);
        }
        return rows_.append(words);
    }
    Status publish() override { return rows_.publish(); }

  private:
    NpyRowFile(NpyRows rows, bool step) : rows_(std::move(rows)), step_(step) {}
    NpyRows rows_;
    const bool step_;
};

class CsvRowFile final : public RowFile {
  public:
    static Result<std::unique_ptr<RowFile>> create(const std::filesystem::path& path, const RowShape& shape) {
        MOTE_ASSIGN_OR_RETURN(auto part, PartFile::create(path));
        std::unique_ptr<CsvRowFile> file(new CsvRowFile(std::move(part), shape));
        std::string head = shape.step ? "step" : "";
        for (const auto& name : shape.headings) head += (head.empty() ? "" : ",") + csvField(name);
        MOTE_RETURN_IF_ERROR(file->write(head + "\n"));
        return std::unique_ptr<RowFile>(std::move(file));
    }

    Status append(const StepColumns& piece) override {
        std::string text;
        for (std::uint64_t row = 0; row < piece.count; ++row) {
            if (shape_.step) text += fmt::format("{},", piece.step);
            for (std::size_t i = 0; i < piece.words.size(); ++i) {
                const auto word = piece.words[i][row];
                if (i > 0) text += ',';
                text +=
                    shape_.isId(i) ? fmt::format("{}", word) : exactNumber(std::bit_cast<double>(word), "");
            }
            text += '\n';
        }
        return write(text);
    }
    Status publish() override { return part_->publish(); }

  private:
    CsvRowFile(std::unique_ptr<PartFile> part, RowShape shape)
        : part_(std::move(part)), shape_(std::move(shape)) {}
    Status write(const std::string& text) { return part_->append(bytesOf(std::span<const char>(text))); }

    std::unique_ptr<PartFile> part_;
    const RowShape shape_;
};

/// All columns of the dataset, and its ids first.
std::vector<std::string> allColumns(const proto::ParticlesManifest& manifest) {
    std::vector<std::string> names;
    if (manifest.ids()) names.emplace_back("id");
    for (const auto& column : manifest.columns()) names.push_back(column.name());
    return names;
}

/// A weight's unit is said even where it is 1: whoever reads the file must not guess.
std::string headingOf(const std::string& name, const AskedRun& run, const ColumnUnits& units) {
    if (name == "weight") return withUnit(name, run.manifest().weight_unit(), true);
    return withUnit(name, unitOfColumn(name, units));
}

Status exportStep(AskedRun& run, std::size_t step, const std::vector<std::string>& names, RowFile& file) {
    auto query = run.query();
    query.set_steps(fmt::format("{}:{}:1", step, step));
    auto& asked = *query.mutable_columns();
    asked.mutable_names()->Assign(names.begin(), names.end());
    while (true) {
        std::uint64_t next = 0;
        bool end = false;
        MOTE_RETURN_IF_ERROR(run.ask(query, {step}, [&](const QueryAnswer& answer) -> Status {
            MOTE_ASSIGN_OR_RETURN(const auto piece, columnsOf(answer, asked));
            next = piece.next;
            end = piece.end;
            return file.append(piece);
        }));
        if (end) return success();
        asked.set_begin(next);
    }
}

/// Writes .npy or .csv: a row for each particle, with its step where there are several.
Status exportRows(const StatsOptions& options, AskedRun& run) {
    RowShape shape;
    shape.step = run.steps().size() > 1;
    shape.names = options.columns.empty() ? allColumns(run.manifest()) : options.columns;
    const auto units = run.units();
    for (const auto& name : shape.names) shape.headings.push_back(headingOf(name, run, units));
    if (shape.names.empty()) {
        return Error{
            ErrorCode::notFound, run.dataset(),
            "was made without columns: make it again from its source (mote-prep particles) to have them"};
    }
    const bool npy = options.exported.extension() == ".npy";
    MOTE_ASSIGN_OR_RETURN(const auto file, npy ? NpyRowFile::create(options.exported, shape)
                                               : CsvRowFile::create(options.exported, shape));
    for (const auto step : run.steps()) MOTE_RETURN_IF_ERROR(exportStep(run, step, shape.names, *file));
    return file->publish();
}

/// Waits for the job's end. Errors: why it failed, or is not waited for: the job is cancelled then.
Result<proto::JobStatus> madeBy(ServerLine& server, const std::string& id, bool quiet) {
    JobPercentage percentage("export", !quiet);
    auto job = awaitJob(server, id, [&](const proto::JobStatus& now) {
        percentage.show(now);
        return success();
    });
    if (!job.ok()) {
        server.line().cancelJob(id, {});
        server.farewell();
        return job;
    }
    if (job->state() == proto::JobStatus::SUCCEEDED) return job;
    return Error{ErrorCode::internal, "", job->error().empty() ? "the export was cancelled" : job->error()};
}

Status fetch(ServerLine& server, const proto::JobStatus& job, const std::filesystem::path& target) {
    MOTE_ASSIGN_OR_RETURN(const auto download, FilmDownload::begin(job, target));
    while (!download->done()) {
        const auto piece = server.answerTo<FilmBytes>(
            [&](auto reply) { server.line().fetchFilm(download->wanted(), std::move(reply)); });
        MOTE_RETURN_IF_ERROR(download->take(piece));
    }
    return success();
}

Status exportOpenPmd(const StatsOptions& options, AskedRun& run) {
    proto::JobRequest request;
    auto& asked = *request.mutable_export_();
    asked.set_dataset(run.dataset() + ".mote");
    asked.set_steps(run.stepsText());
    if (run.selection()) *asked.mutable_select() = *run.selection();
    asked.mutable_columns()->Assign(options.columns.begin(), options.columns.end());
    auto& server = run.server();
    MOTE_ASSIGN_OR_RETURN(const auto submitted, server.answerTo<proto::JobStatus>([&](auto reply) {
        server.line().submitJob(request, std::move(reply));
    }));
    MOTE_ASSIGN_OR_RETURN(const auto job, madeBy(server, submitted.id(), options.quiet));
    const auto fetched = fetch(server, job, options.exported);
    // The server need not keep it: a finished export that is cancelled is removed.
    server.line().cancelJob(job.id(), {});
    server.farewell();
    return fetched;
}

}  // namespace

Status exportParticles(const StatsOptions& options, AskedRun& run) {
    return options.exported.extension() == ".h5" ? exportOpenPmd(options, run) : exportRows(options, run);
}

}  // namespace mote::client
