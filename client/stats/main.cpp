// SPDX-License-Identifier: GPL-3.0-or-later

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <optional>
#include <span>
#include <string_view>

#include "client/shared/interrupt.h"
#include "client/shared/part_file.h"
#include "client/shared/server_line.h"
#include "client/stats/asked_run.h"
#include "client/stats/npy.h"
#include "client/stats/options.h"
#include "client/stats/statistics_text.h"
#include "protocol/quantity/manifest_columns.h"
#include "protocol/quantity/statistic.h"
#include "protocol/scene/complain.h"
#include "protocol/scene/utf8.h"

namespace mote::client {
namespace {

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
        if (form() == NumbersForm::json) return say(jsonLine(step));
        steps_.push_back(std::move(step));
        return success();
    }

    Status finish() const {
        notes_.finish();
        if (form() == NumbersForm::json) return success();
        if (form() == NumbersForm::table) return say(toTerminalLines(tableText(steps_, units_)));
        if (form() == NumbersForm::npy) return writeNpy(options_.file, steps_, units_);
        MOTE_ASSIGN_OR_RETURN(const auto file, PartFile::create(options_.file));
        MOTE_RETURN_IF_ERROR(append(*file, csvText(steps_, units_)));
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
    if (!run.selection() && kept && further.empty()) {
        auto steps = statisticsOf(run.manifest(), run.steps());
        if (!steps.ok()) return Error{steps.error().code, run.dataset(), steps.error().message};
        for (auto& step : *steps) MOTE_RETURN_IF_ERROR(teller.take(std::move(step)));
        return teller.finish();
    }
    auto query = run.query();
    auto& asked = *query.mutable_statistics();
    if (!further.empty()) {
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
