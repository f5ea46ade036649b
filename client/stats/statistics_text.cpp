// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/stats/statistics_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "client/shared/number_text.h"
#include "client/stats/json_notes.h"
#include "client/stats/npy.h"
#include "protocol/scene/json_string.h"

namespace mote::client {
namespace {

/// What lines of several steps show, as many as there are of the first ones.
constexpr std::array<std::string_view, 22> usual{
    "n_particle",  "charge",   "mean_energy", "sigma_x",  "sigma_y", "sigma_z", "norm_emit_x", "norm_emit_y",
    "norm_emit_z", "sigma_px", "sigma_py",    "sigma_pz", "emit_x",  "emit_y",  "emit_z",      "mean_x",
    "mean_y",      "mean_z",   "mean_px",     "mean_py",  "mean_pz", "min_x"};
constexpr std::size_t mostShown = 11;

constexpr std::size_t gap = 2;  // blanks between columns

/// A number and its unit, parted where decimal points are to stand below each other.
struct Entry {
    std::string name, whole, fraction, unit;
};

Entry entryOf(const std::string& name, double value, const ColumnUnits& units) {
    const auto unit = scaledUnit(value, unitOf(name, units));
    const auto text = shortNumber(value, unit);
    const auto point = std::min(text.find('.'), text.size());
    return {name, text.substr(0, point), text.substr(point), std::isfinite(value) ? unit.name : ""};
}

std::string headOf(const StepStatistics& row) {
    const auto unit = scaledUnit(row.time, "s");
    return fmt::format("step {}, iteration {}, time {} {}", row.step, row.iteration,
                       shortNumber(row.time, unit), unit.name);
}

std::string oneStep(const StepStatistics& statistics, const ColumnUnits& units) {
    std::vector<Entry> entries;
    std::size_t nameWidth = 0, wholeWidth = 0, fractionWidth = 0;
    for (std::size_t i = 0; i < statistics.names.size(); ++i) {
        const auto& entry = entries.emplace_back(entryOf(statistics.names[i], statistics.values[i], units));
        nameWidth = std::max(nameWidth, widthOf(entry.name));
        wholeWidth = std::max(wholeWidth, entry.whole.size());
        // An exponent stands out.
        if (entry.fraction.find('e') == std::string::npos)
            fractionWidth = std::max(fractionWidth, entry.fraction.size());
    }
    std::string text = headOf(statistics) + "\n";
    for (const auto& entry : entries) {
        auto line =
            fmt::format("  {}  {}{} {}", padRight(entry.name, nameWidth), padLeft(entry.whole, wholeWidth),
                        padRight(entry.fraction, fractionWidth), entry.unit);
        line.erase(line.find_last_not_of(' ') + 1);
        text += line + "\n";
    }
    return text;
}

/// One column of a table of steps.
struct TableColumn {
    std::string name;
    std::string unit;
    std::vector<std::string> numbers;
    std::size_t width = 0;
};

template <class Value>
TableColumn tableColumn(const std::string& name, const std::string& unit, const StatisticsOfSteps& steps,
                        Value value) {
    double greatest = 0.0;
    for (const auto& row : steps) {
        if (std::isfinite(value(row))) greatest = std::max(greatest, std::abs(value(row)));
    }
    const auto scaled = scaledUnit(greatest, unit);
    TableColumn column{name, scaled.name, {}, std::max(widthOf(name), widthOf(scaled.name))};
    for (const auto& row : steps) {
        column.numbers.push_back(shortNumber(value(row), scaled));
        column.width = std::max(column.width, column.numbers.back().size());
    }
    return column;
}

std::vector<TableColumn> tableColumns(const StatisticsOfSteps& steps, const ColumnUnits& units) {
    const auto& names = steps.front().names;
    std::vector<TableColumn> columns{
        tableColumn("step", "", steps,
                    [](const StepStatistics& row) { return static_cast<double>(row.step); }),
        tableColumn("time", "s", steps, [](const StepStatistics& row) { return row.time; })};
    for (const auto name : usual) {
        const auto found = std::ranges::find(names, name);
        if (found == names.end() || columns.size() == mostShown) continue;
        const auto index = static_cast<std::size_t>(found - names.begin());
        const auto defined = [index](const StepStatistics& row) { return std::isfinite(row.values[index]); };
        if (!std::ranges::any_of(steps, defined)) continue;
        columns.push_back(tableColumn(*found, unitOf(*found, units), steps,
                                      [index](const StepStatistics& row) { return row.values[index]; }));
    }
    return columns;
}

std::string manySteps(const StatisticsOfSteps& steps, const ColumnUnits& units) {
    const auto columns = tableColumns(steps, units);
    const auto line = [&](auto textOf) {
        std::string text;
        for (const auto& column : columns)
            text += padLeft(textOf(column), column.width + (text.empty() ? 0 : gap));
        return text + "\n";
    };
    std::string text = line([](const auto& column) { return column.name; });
    text += line([](const auto& column) { return column.unit; });
    for (std::size_t i = 0; i < steps.size(); ++i)
        text += line([i](const auto& column) { return column.numbers[i]; });
    return text;
}

}  // namespace

std::vector<std::size_t> namesOfColumns(const std::vector<std::string>& names,
                                        const std::vector<std::string>& columns) {
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (std::ranges::all_of(columnsOf(names[i]),
                                [&](const auto& each) { return std::ranges::count(columns, each) > 0; }))
            kept.push_back(i);
    }
    return kept;
}

std::vector<std::string> furtherNames(const std::vector<std::string>& names,
                                      const std::vector<std::string>& columns) {
    std::vector<std::string> further;
    for (const auto& column : columns) {
        const auto isOf = [&](const auto& name) { return std::ranges::count(columnsOf(name), column) > 0; };
        if (std::ranges::any_of(names, isOf)) continue;
        for (const auto* kind : {"mean", "sigma", "min", "max"})
            further.push_back(fmt::format("{}_{}", kind, column));
    }
    return further;
}

StepStatistics someOf(const StepStatistics& all, const std::vector<std::size_t>& places) {
    StepStatistics some{all.step, all.iteration, all.time, {}, {}, {}, {}};
    some.notes = all.notes;
    for (const auto place : places) {
        some.names.push_back(all.names[place]);
        some.values.push_back(all.values[place]);
    }
    return some;
}

std::string jsonLine(const StepStatistics& statistics) {
    std::string line = fmt::format("{{\"step\": {}, \"iteration\": {}, \"time\": {}", statistics.step,
                                   statistics.iteration, exactNumber(statistics.time, "null"));
    for (std::size_t i = 0; i < statistics.names.size(); ++i)
        line += fmt::format(", {}: {}", jsonString(statistics.names[i]),
                            exactNumber(statistics.values[i], "null"));
    return line + jsonNotes(statistics.notes) + "}\n";
}

std::string csvText(const StatisticsOfSteps& steps, const ColumnUnits& units) {
    std::string text = "step,iteration,time [s]";
    for (const auto& name : steps.front().names) text += "," + csvField(withUnit(name, unitOf(name, units)));
    text += "\n";
    for (const auto& row : steps) {
        text += fmt::format("{},{},{}", row.step, row.iteration, exactNumber(row.time, ""));
        for (const double value : row.values) text += "," + exactNumber(value, "");
        text += "\n";
    }
    return text;
}

Status writeNpy(const std::filesystem::path& path, const StatisticsOfSteps& steps, const ColumnUnits& units) {
    std::vector<NpyField> fields{{"step", "<i8"}, {"iteration", "<i8"}, {"time", "<f8", "time [s]"}};
    for (const auto& name : steps.front().names) {
        auto title = withUnit(name, unitOf(name, units));
        fields.push_back({name, "<f8", title == name ? std::string() : std::move(title)});
    }
    MOTE_ASSIGN_OR_RETURN(auto file, NpyRows::create(path, fields));
    for (const auto& row : steps) {
        std::vector<std::uint64_t> words{row.step, static_cast<std::uint64_t>(row.iteration),
                                         std::bit_cast<std::uint64_t>(row.time)};
        for (const double value : row.values) words.push_back(std::bit_cast<std::uint64_t>(value));
        MOTE_RETURN_IF_ERROR(file.append(words));
    }
    return file.publish();
}

std::string tableText(const StatisticsOfSteps& steps, const ColumnUnits& units) {
    return steps.size() == 1 ? oneStep(steps.front(), units) : manySteps(steps, units);
}

}  // namespace mote::client
