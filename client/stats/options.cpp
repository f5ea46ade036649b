// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/stats/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>

#include "protocol/cli/command.h"
#include "protocol/quantity/quantity.h"
#include "protocol/scene/step_range.h"

namespace mote::client {
namespace {

constexpr const char* footer =
    R"(Without --json, --csv or --npy: a table: of one step all statistics, of several steps the usual ones, a line each.
Numbers are in m, eV/c, s, eV and C; only tables have prefixes. What is not defined (no particle) is null in JSON, nothing
in CSV and NaN in NPY. Headings of CSV have units ("sigma_x [m]"), fields of NPY the same as titles. Statistics without
--select are those of preparation, from the source's own values; where others are limited by how coarsely a column is
stored, a note on stderr says so, and "notes" in JSON.

A SELECTION is {"ranges": [{"column": "x", "min": 1e-3}], "density": {"max": 0.4}, "polygon": {"columns": ["x", "px"],
"points": [[0, 0], [1e-3, 0], [0, 2e4]]}, "outermost": {"plane": "x", "share": 0.1}, "ids": [7, 8], "step": 12,
"all": [...], "any": [...], "not": {...}}, and holds the particles that meet all that is given. With "step" it is made
in that step and follows the same ids through the others.

Files appear whole, or not at all. docs/NUMBERS.md says what each number is.

Examples:
  mote-stats data/beam --spawn data=/scratch/plots
  mote-stats data/beam --connect ~/.mote/connection.json --steps 59 --columns x,px
  mote-stats data/beam --connect c.json --select halo.json --json | jq .norm_emit_x
  mote-stats data/beam --connect c.json --csv run.csv
  mote-stats data/beam --connect c.json --steps 3 --slices z:50:charge --csv slices.csv
  mote-stats data/beam --connect c.json --steps 3 --histogram x,px --bins 512,512 --range x=-4e-3:4e-3 --npy h.npy
  mote-stats data/beam --connect c.json --steps 59 --select halo.json --export halo.h5

Exit status: 0 on success, 2 for wrong usage, 128 + N after signal N, else 1.)";

constexpr std::uint32_t mostBins = 4096;  // of an axis

/// What the command line says before it is checked.
struct RawOptions {
    StatsOptions options;
    std::string connect, select, columns, slices, histogram, bins, csv, npy, exported, boundsOf;
    std::vector<std::string> ranges;
    bool unweighted = false, json = false;
};

void declare(const cli::Command& app, RawOptions& raw) {
    app.footer(footer);
    app.option("DATASET", raw.options.dataset, "A dataset of particles, ROOT/NAME");
    const auto server = app.group("server", "Which server answers (exactly one of these)");
    server.option("--connect", raw.connect, "Connection file of a running server");
    server.option("--spawn", raw.options.roots, "Start a private server with this root, NAME=DIR; repeatable")
        .repeatable();
    server.requireOneOption();
    app.option("--steps", raw.options.steps, "Steps by index, the last included; default: all")
        .valueName("FIRST:LAST:STRIDE");
    app.option("--select", raw.select, "Only these particles: a file with a selection")
        .valueName("SELECTION.json");
    app.option("--columns", raw.columns, "Only statistics of these columns; for --export: these columns")
        .valueName("x,px,...");
    app.option("--slices", raw.slices,
               "Statistics of slices along a column, and how many: of equal length, or of equal charge")
        .valueName("z:50[:even|charge]");
    const auto histogram = app.group("histogram", "A histogram instead of statistics");
    histogram.option("--histogram", raw.histogram, "Of one or two columns or derived quantities")
        .valueName("x[,px]");
    histogram
        .option("--bins", raw.bins,
                "How many, for all columns or for each, 1 to 4096; default: 100, in tables as many as fit")
        .valueName("N[,N]");
    histogram
        .option("--range", raw.ranges,
                "Where the bins of a column begin and end; default: the range over all steps; repeatable")
        .valueName("x=A:B");
    histogram
        .option("--bounds-of", raw.boundsOf,
                "What the bins cover without --range: the values of all steps (run), of the step, or of the "
                "step's selection")
        .oneOf({"run", "step", "selection"})
        .valueName("WHAT");
    histogram.flag("--unweighted", raw.unweighted, "Counts each particle as 1, not by its weight");
    const auto form = app.group("form", "How numbers are written (at most one of these)");
    form.flag("--json", raw.json, "Prints one line of JSON per step");
    form.option("--csv", raw.csv, "A file of comma-separated values").valueName("FILE");
    form.option("--npy", raw.npy,
                "A file for numpy: statistics as a structured array, counts as [step, x, px], without the "
                "first of one step")
        .valueName("FILE");
    app.option("--export", raw.exported,
               "The particles themselves: openPMD-beamphysics HDF5 (.h5), NumPy (.npy) or text (.csv)")
        .valueName("FILE");
    app.flag("--quiet", raw.options.quiet, "No progress on stderr");
}

std::vector<std::string> split(const std::string& text, char at) {
    std::vector<std::string> parts;
    std::size_t begin = 0;
    while (true) {
        const auto end = text.find(at, begin);
        parts.push_back(text.substr(begin, end - begin));
        if (end == std::string::npos) return parts;
        begin = end + 1;
    }
}

/// Names of columns, none of them twice.
Result<std::vector<std::string>> namesIn(const std::string& text, const std::string& option) {
    auto names = splitNames(text);
    std::set<std::string> seen;
    for (const auto& name : names) {
        const auto checked = checkColumnName(name, option);
        if (!checked.ok()) return checked.error();
        if (!seen.insert(name).second) return invalid(option, fmt::format("\"{}\" is given twice", name));
    }
    return names;
}

Status checkServers(RawOptions& raw) {
    for (const auto& root : raw.options.roots) {
        const auto equals = root.find('=');
        if (equals == 0 || equals == std::string::npos || equals + 1 == root.size()) {
            return invalid("--spawn", fmt::format("\"{}\" is not NAME=DIR", root));
        }
    }
    if (!raw.connect.empty()) raw.options.connect = raw.connect;
    return success();
}

Status checkBins(const RawOptions& raw, proto::HistogramQuery& query) {
    if (raw.bins.empty()) return success();
    const auto counts = split(raw.bins, ',');
    if (counts.size() != 1 && counts.size() != static_cast<std::size_t>(query.axes_size()))
        return invalid("--bins",
                       fmt::format("says {} numbers for {} columns", counts.size(), query.axes_size()));
    for (int i = 0; i < query.axes_size(); ++i) {
        const auto& text = counts[counts.size() == 1 ? 0 : static_cast<std::size_t>(i)];
        std::uint32_t bins = 0;
        const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), bins);
        if (code != std::errc() || end != text.data() + text.size() || bins < 1 || bins > mostBins)
            return invalid("--bins", fmt::format("\"{}\" is not a number from 1 to {}", text, mostBins));
        query.mutable_axes(i)->set_bins(bins);
    }
    return success();
}

/// "x=A:B".
Status checkRange(const std::string& text, proto::HistogramQuery& query) {
    const auto equals = text.rfind('=');  // an expression may hold one, numbers none
    const auto colon = text.find(':', equals == std::string::npos ? 0 : equals);
    const auto wrong = invalid(
        "--range",
        fmt::format("\"{}\" is not COLUMN=FROM:TO, such as x=-1e-3:1e-3, in the column's unit", text));
    if (equals == std::string::npos || colon == std::string::npos) return wrong;
    const auto from = cli::parseNumber(text.substr(equals + 1, colon - equals - 1));
    const auto to = cli::parseNumber(text.substr(colon + 1));
    if (!from || !to) return wrong;
    if (!std::isfinite(*from) || !std::isfinite(*to) || !(*from < *to))
        return invalid("--range", fmt::format("\"{}\" must be finite, and ascend", text));
    const auto axis = std::find_if(query.mutable_axes()->begin(), query.mutable_axes()->end(),
                                   [&](const auto& each) { return each.column() == text.substr(0, equals); });
    if (axis == query.mutable_axes()->end())
        return invalid("--range", fmt::format("\"{}\" is none of the histogram's columns", text));
    if (axis->range_size() > 0) return invalid("--range", fmt::format("\"{}\": is given twice", text));
    axis->add_range(*from);
    axis->add_range(*to);
    return success();
}

Status checkHistogram(RawOptions& raw) {
    if (raw.histogram.empty()) {
        if (raw.bins.empty() && raw.ranges.empty() && raw.boundsOf.empty() && !raw.unweighted)
            return success();
        return invalid("--histogram",
                       "is missing: --bins, --range, --bounds-of and --unweighted are of a histogram");
    }
    MOTE_ASSIGN_OR_RETURN(const auto names, namesIn(raw.histogram, "--histogram"));
    if (names.size() > 2) return invalid("--histogram", "is of one column or two");
    auto& query = raw.options.histogram.emplace();
    for (const auto& name : names) query.add_axes()->set_column(name);
    query.set_unweighted(raw.unweighted);
    using BoundsOf = StatsOptions::BoundsOf;
    if (raw.boundsOf == "step") raw.options.boundsOf = BoundsOf::step;
    if (raw.boundsOf == "selection") raw.options.boundsOf = BoundsOf::selection;
    MOTE_RETURN_IF_ERROR(checkBins(raw, query));
    for (const auto& range : raw.ranges) MOTE_RETURN_IF_ERROR(checkRange(range, query));
    return success();
}

/// "z", "z:50" or "z:50:charge".
Status checkSlices(RawOptions& raw) {
    if (raw.slices.empty()) return success();
    auto& slices = raw.options.slices;
    auto parts = split(raw.slices, ':');
    if (parts.size() > 1 && (parts.back() == "even" || parts.back() == "charge")) {
        slices.of = parts.back();
        parts.pop_back();
    }
    slices.column = parts.front();
    const auto column = checkColumnName(slices.column, "--slices");
    if (!column.ok()) return column.error();
    if (parts.size() == 1) return success();
    std::uint32_t count = 0;
    const auto& text = parts[1];
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), count);
    if (parts.size() > 2 || code != std::errc() || end != text.data() + text.size() || count < 1)
        return invalid("--slices", fmt::format("\"{}\" is not COLUMN:COUNT:even or :charge", raw.slices));
    slices.count = count;
    return success();
}

Status checkForm(RawOptions& raw) {
    auto& options = raw.options;
    const int forms = (raw.json ? 1 : 0) + (raw.csv.empty() ? 0 : 1) + (raw.npy.empty() ? 0 : 1);
    if (forms > 1) return invalid("--json", "give one of --json, --csv and --npy");
    if (raw.json) options.form = NumbersForm::json;
    if (!raw.csv.empty()) options.form = NumbersForm::csv;
    if (!raw.npy.empty()) options.form = NumbersForm::npy;
    options.file = raw.csv.empty() ? raw.npy : raw.csv;
    options.exported = raw.exported;
    static constexpr std::array<std::string_view, 3> endings{".h5", ".npy", ".csv"};
    if (!raw.exported.empty() && std::ranges::count(endings, options.exported.extension().string()) == 0)
        return invalid("--export", fmt::format("\"{}\" does not end in .h5, .npy or .csv", raw.exported));
    if (!raw.exported.empty() && options.exported == options.file)
        return invalid("--export", "is the file of the numbers too");
    return success();
}

/// Ranges may follow one another, and the dataset them: it is what is no range.
Status checkDataset(RawOptions& raw) {
    auto& dataset = raw.options.dataset;
    if (dataset.empty() && !raw.ranges.empty() && raw.ranges.back().find('=') == std::string::npos) {
        dataset = raw.ranges.back();
        raw.ranges.pop_back();
    }
    return dataset.empty() ? Status(invalid("DATASET", "is required: ROOT/NAME")) : success();
}

Status check(RawOptions& raw) {
    MOTE_RETURN_IF_ERROR(checkDataset(raw));
    MOTE_RETURN_IF_ERROR(checkServers(raw));
    const auto steps = checkStepRange(raw.options.steps);
    if (!steps.ok()) return invalid("--steps", steps.error().message);
    if (raw.select.starts_with('{'))
        return invalid("--select", "is the name of a file; write the selection into one");
    raw.options.select = raw.select;
    if (!raw.columns.empty()) {
        MOTE_ASSIGN_OR_RETURN(raw.options.columns, namesIn(raw.columns, "--columns"));
    }
    MOTE_RETURN_IF_ERROR(checkHistogram(raw));
    MOTE_RETURN_IF_ERROR(checkSlices(raw));
    if (raw.options.histogram && !raw.slices.empty())
        return invalid("--slices", "are of statistics, not of a histogram");
    MOTE_RETURN_IF_ERROR(checkForm(raw));
    if (raw.options.columns.empty() || !raw.options.histogram || !raw.options.exported.empty())
        return success();
    return invalid("--columns", "is of statistics and exports; a histogram names its own");
}

}  // namespace

std::variant<StatsOptions, int> parseStatsOptions(int argc, const char* const* argv) {
    RawOptions raw;
    const cli::Program program("mote-stats prints the numbers behind the picture of a particle run.",
                               "mote-stats");
    declare(program.command(), raw);
    if (const auto end = program.parse(argc, argv, [&] { return check(raw); })) return *end;
    return std::move(raw.options);
}

}  // namespace mote::client
