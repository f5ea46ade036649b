// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <deque>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/shared/film_download.h"
#include "client/shared/interrupt.h"
#include "client/shared/jobs.h"
#include "client/shared/numbers.h"
#include "client/shared/part_file.h"
#include "client/shared/server_line.h"
#include "client/stats/npy.h"
#include "client/stats/options.h"
#include "client/stats/statistics_text.h"
#include "protocol/base/complain.h"
#include "protocol/base/error.h"
#include "protocol/base/json.h"
#include "protocol/base/utf8.h"
#include "protocol/mote.pb.h"
#include "protocol/quantity/manifest_columns.h"
#include "protocol/quantity/statistic.h"
#include "protocol/scene/selection.h"
#include "protocol/scene/step_range.h"

namespace mote::client {
namespace {

/// A dataset of particles of a server, and the questions that mote-stats has for it. Main thread.
class AskedRun {
  public:
    /// Reads the selection, and asks for the dataset. Errors: invalidArgument, notFound, unsupported (it
    /// holds no particles), with the option that is wrong.
    static Result<AskedRun> open(const StatsOptions& options, ServerLine& server);

    const std::string& dataset() const { return dataset_; }
    const proto::ParticlesManifest& manifest() const { return manifest_; }
    ColumnUnits units() const { return columnUnits(manifest_); }
    /// Those that were chosen, at least one.
    const std::vector<std::size_t>& steps() const { return steps_; }
    const std::optional<proto::Selection>& selection() const { return selection_; }

    /// These, as queries and jobs have them.
    std::string stepsText() const;
    /// A query about the selection in the chosen steps, to which the question itself is to be added.
    proto::Query query() const;
    /// Hands over the answers, one after the other, each for the next of `steps`. Errors: the server's, those
    /// of `take`, which ends the query, corrupt (an answer for another step), cancelled.
    Status ask(const proto::Query& query, const std::vector<std::size_t>& steps,
               const std::function<Status(const QueryAnswer&)>& take);

    ServerLine& server() { return *server_; }

  private:
    AskedRun(ServerLine& server, std::string dataset) : server_(&server), dataset_(std::move(dataset)) {}

    ServerLine* server_;
    std::string dataset_;
    proto::ParticlesManifest manifest_;
    std::vector<std::size_t> steps_;
    std::optional<proto::Selection> selection_;
};

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
    auto told = [&]() -> Status {
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
    bool step = false;  ///< first of all, if there are several
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

/// Writes .npy or .csv: a row for each particle, with its step if there are several.
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
    auto fetched = fetch(server, job, options.exported);
    // The server need not keep it: a finished export that is cancelled is removed.
    server.line().cancelJob(job.id(), {});
    server.farewell();
    return fetched;
}

/// Writes the particles of a selection as a file of the user's, by the ending of options.exported: openPMD as
/// a job of the server's makes it, NumPy and text from columns that are asked for piece by piece. The file
/// appears whole; one of its name is replaced. Errors: the server's, notFound (the dataset was made without
/// columns), cancelled, those of the system.
Status exportParticles(const StatsOptions& options, AskedRun& run) {
    return options.exported.extension() == ".h5" ? exportOpenPmd(options, run) : exportRows(options, run);
}

Status say(std::string_view text) {
    if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0)
        return success();
    return Error{ErrorCode::internal, "stdout", "cannot be written to any more"};
}

Status append(PartFile& file, std::string_view text) {
    return file.append(bytesOf(std::span<const char>(text)));
}

/// What limits the numbers, on stderr: of the first steps that have such notes, and how many more there are.
class NoteTeller {
  public:
    explicit NoteTeller(bool quiet) : quiet_(quiet) {}

    void take(std::uint32_t step, const std::vector<std::string>& notes) {
        for (const auto& note : notes) {
            constexpr std::size_t most = 8;
            if (!quiet_ && told_ < most) complain("mote-stats", fmt::format("step {}: {}", step, note));
            ++told_;
            more_ = told_ > most ? told_ - most : 0;
        }
    }
    void finish() const {
        if (!quiet_ && more_ > 0) complain("mote-stats", fmt::format("{} more notes like these", more_));
    }

  private:
    const bool quiet_;
    std::size_t told_ = 0, more_ = 0;
};

// ----------------------------------------------------------------------------------------- statistics

/// The statistics of the options' columns, step by step.
class StatisticsTeller {
  public:
    StatisticsTeller(const StatsOptions& options, const AskedRun& run)
        : options_(options), units_(run.units()), notes_(options.quiet) {}

    Status take(StepStatistics step) {
        notes_.take(step.step, step.notes);
        if (names_.empty()) choose(step.names);
        if (step.names != names_)
            return Error{ErrorCode::corrupt, "", "the server's statistics differ from step to step"};
        if (!options_.columns.empty()) step = someOf(step, places_);
        if (!options_.slices.column.empty() && step.slices.empty())
            return Error{ErrorCode::corrupt, "", "the server's statistics are without slices"};
        if (form() == NumbersForm::json) return say(jsonLine(step));
        steps_.push_back(std::move(step));
        return success();
    }

    Status finish() const {
        notes_.finish();
        if (form() == NumbersForm::json) return success();
        const auto& along = options_.slices.column;
        if (form() == NumbersForm::table) return say(toTerminalLines(tableText(steps_, units_, along)));
        if (form() == NumbersForm::npy) return writeNpy(options_.file, steps_, units_, along);
        MOTE_ASSIGN_OR_RETURN(const auto file, PartFile::create(options_.file));
        MOTE_RETURN_IF_ERROR(append(*file, csvText(steps_, units_, along)));
        return file->publish();
    }

  private:
    NumbersForm form() const { return options_.form.value_or(NumbersForm::table); }
    void choose(const std::vector<std::string>& names) {
        names_ = names;
        if (!options_.columns.empty()) places_ = namesOfColumns(names, options_.columns);
    }

    const StatsOptions& options_;
    const ColumnUnits units_;
    std::vector<std::string> names_;
    std::vector<std::size_t> places_;  // of those that are told
    StatisticsOfSteps steps_;
    NoteTeller notes_;
};

Status tellStatistics(const StatsOptions& options, AskedRun& run) {
    StatisticsTeller teller(options, run);
    // Where preparation left none, the server finds them from the columns.
    const auto& own = run.manifest().statistic_names();
    const bool kept = !own.empty() || run.manifest().columns().empty();
    std::vector<std::string> names(own.begin(), own.end());
    if (names.empty()) std::ranges::transform(statistics(), std::back_inserter(names), &Statistic::name);
    const auto further = furtherNames(names, options.columns);
    for (const auto& name : further) {
        const auto column = columnsOf(name).front();
        const auto made = Quantity::make(column, mote::columnsOf(run.manifest()));
        if (!made.ok())
            return Error{made.error().code, "--columns",
                         fmt::format("\"{}\" {}", column, made.error().message)};
    }
    const auto& slices = options.slices;
    if (!run.selection() && kept && further.empty() && slices.column.empty()) {
        auto steps = statisticsOf(run.manifest(), run.steps());
        if (!steps.ok()) return Error{steps.error().code, run.dataset(), steps.error().message};
        for (auto& step : *steps) MOTE_RETURN_IF_ERROR(teller.take(std::move(step)));
        return teller.finish();
    }
    auto query = run.query();
    auto& asked = *query.mutable_statistics();
    asked.set_slices(slices.column);
    asked.set_slices_of(slices.of);
    if (slices.count) asked.set_slice_count(*slices.count);
    if (!further.empty() || (!slices.column.empty() && !options.columns.empty())) {
        for (const auto place : namesOfColumns(names, options.columns)) asked.add_names(names[place]);
        for (const auto& name : further) asked.add_names(name);
    }
    MOTE_RETURN_IF_ERROR(run.ask(query, run.steps(), [&](const QueryAnswer& answer) -> Status {
        MOTE_ASSIGN_OR_RETURN(auto step, statisticsOf(answer));
        return teller.take(std::move(step));
    }));
    return teller.finish();
}

// ----------------------------------------------------------------------------------------- histograms

/// The histograms, step by step; files grow as they come.
class HistogramTeller {
  public:
    HistogramTeller(const StatsOptions& options, const AskedRun& run)
        : options_(options), units_(run.units()), steps_(run.steps().size()), notes_(options.quiet) {}

    Status take(const StepHistogram& histogram) {
        notes_.take(histogram.step, histogram.notes);
        switch (options_.form.value_or(NumbersForm::table)) {
            case NumbersForm::json:
                return say(jsonLine(histogram));
            case NumbersForm::table:
                return say(toTerminalLines(pictureText(histogram, units_)));
            case NumbersForm::csv:
                if (!file_) MOTE_RETURN_IF_ERROR(open(csvHead(histogram.columns, units_)));
                return append(*file_, csvText(histogram));
            case NumbersForm::npy:
                if (!file_) MOTE_RETURN_IF_ERROR(open(npyHead(shapeOf(histogram))));
                return file_->append(bytesOf(std::span<const double>(histogram.counts)));
        }
        return success();
    }
    Status finish() {
        notes_.finish();
        return file_ ? file_->publish() : success();
    }

  private:
    Status open(const std::string& head) {
        MOTE_ASSIGN_OR_RETURN(file_, PartFile::create(options_.file));
        return append(*file_, head);
    }
    std::vector<std::size_t> shapeOf(const StepHistogram& histogram) const {
        std::vector<std::size_t> shape;
        if (steps_ > 1) shape.push_back(steps_);
        for (std::size_t i = 0; i < histogram.edges.size(); ++i) shape.push_back(histogram.bins(i));
        return shape;
    }

    const StatsOptions& options_;
    const ColumnUnits units_;
    const std::size_t steps_;
    std::unique_ptr<PartFile> file_;
    NoteTeller notes_;
};

/// A quantity as an expression, so that it is of values as the dataset has them, not as the source had them.
std::string quoted(const std::string& name, const proto::ParticlesManifest& manifest) {
    const bool own = std::ranges::count(manifest.columns(), name, &proto::ColumnEntry::name) > 0;
    return own || !Expression::looksLikeOne(name) ? fmt::format("'{}'", name) : name;
}

/// Gives axes without a range that of one step's particles, or of those chosen.
Status setRanges(const StatsOptions& options, AskedRun& run, std::size_t step, proto::HistogramQuery& to) {
    auto query = run.query();
    query.set_steps(fmt::format("{}:{}:1", step, step));
    if (options.boundsOf == StatsOptions::BoundsOf::step) query.clear_select();
    for (const auto& axis : to.axes()) {
        for (const auto* kind : {"min", "max"})
            query.mutable_statistics()->add_names(
                fmt::format("{}_{}", kind, quoted(axis.column(), run.manifest())));
    }
    return run.ask(query, {step}, [&](const QueryAnswer& answer) -> Status {
        MOTE_ASSIGN_OR_RETURN(const auto found, statisticsOf(answer));
        for (int i = 0; i < to.axes_size(); ++i) {
            auto& axis = *to.mutable_axes(i);
            double low = found.values.at(2 * static_cast<std::size_t>(i));
            double high = found.values.at(2 * static_cast<std::size_t>(i) + 1);
            if (axis.range_size() > 0 || !(low <= high)) continue;
            const double half = low < high ? 0.0 : std::max(0.5, 1e-9 * std::abs(low));
            axis.add_range(low - half);
            axis.add_range(high + half);
        }
        return success();
    });
}

Status tellHistograms(const StatsOptions& options, AskedRun& run) {
    HistogramTeller teller(options, run);
    auto query = run.query();
    auto& asked = *query.mutable_histogram() = *options.histogram;
    const auto shown = shownBins(static_cast<std::size_t>(asked.axes_size()));
    for (int i = 0; i < asked.axes_size(); ++i) {
        const bool table = options.form.value_or(NumbersForm::table) == NumbersForm::table;
        if (table && !asked.axes(i).has_bins())
            asked.mutable_axes(i)->set_bins(shown[static_cast<std::size_t>(i)]);
    }
    const auto tell = [&](const QueryAnswer& answer) -> Status {
        MOTE_ASSIGN_OR_RETURN(const auto histogram, histogramOf(answer, asked));
        return teller.take(histogram);
    };
    if (options.boundsOf == StatsOptions::BoundsOf::run) {
        MOTE_RETURN_IF_ERROR(run.ask(query, run.steps(), tell));
        return teller.finish();
    }
    const auto wanted = asked;
    for (const auto step : run.steps()) {
        asked = wanted;
        MOTE_RETURN_IF_ERROR(setRanges(options, run, step, asked));
        query.set_steps(fmt::format("{}:{}:1", step, step));
        MOTE_RETURN_IF_ERROR(run.ask(query, {step}, tell));
    }
    return teller.finish();
}

/// Asks a server for statistics or histograms and tells them. Errors: of the options' files (the selection,
/// the output), the server's (a dataset, a column, a step that is not there), cancelled (interrupted; nothing
/// half-written is left).
Status runStats(const StatsOptions& options, const Interrupt& interrupt) {
    // Numbers need no graphics: a private server draws nothing.
    const ServerChoice choice{options.connect, {serverBesideUs(), options.roots, "cpu"}};
    Wakeup wakeup;
    MOTE_ASSIGN_OR_RETURN(const auto server, ServerLine::open("mote-stats", choice, wakeup, interrupt));
    MOTE_ASSIGN_OR_RETURN(auto run, AskedRun::open(options, *server));
    if (options.wantsNumbers())
        MOTE_RETURN_IF_ERROR(options.histogram ? tellHistograms(options, run) : tellStatistics(options, run));
    return options.exported.empty() ? success() : exportParticles(options, run);
}

}  // namespace
}  // namespace mote::client

int main(int argc, char** argv) {
    using namespace mote::client;
    return runProgram("mote-stats", parseStatsOptions, runStats, argc, argv);
}
