// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/stats/statistics_text.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "client/shared/numbers.h"
#include "client/stats/npy.h"
#include "protocol/base/json_string.h"

namespace mote::client {
namespace {

/// What limits numbers, as a member of a line of JSON: ', "notes": ["..."]', to be put behind a line's other
/// members; "" if there are none.
std::string jsonNotes(const std::vector<std::string>& notes) {
    std::string list;
    for (const auto& note : notes) list += (list.empty() ? "" : ", ") + jsonString(note);
    return list.empty() ? list : ", \"notes\": [" + list + "]";
}

template <class Numbers>
std::string jsonArray(const Numbers& numbers) {
    std::string text = "[";
    for (const double number : numbers) {
        if (text.size() > 1) text += ", ";
        text += exactNumber(number, "null");
    }
    return text + "]";
}

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

/// The usual ones behind what tells the rows apart.
std::vector<TableColumn> tableColumns(const StatisticsOfSteps& steps, const ColumnUnits& units,
                                      std::vector<TableColumn> columns) {
    const auto& names = steps.front().names;
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

/// A line for each row.
std::string tableOf(const StatisticsOfSteps& steps, const std::vector<TableColumn>& columns) {
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

std::string manySteps(const StatisticsOfSteps& steps, const ColumnUnits& units) {
    return tableOf(
        steps,
        tableColumns(steps, units,
                     {tableColumn("step", "", steps,
                                  [](const StepStatistics& row) { return static_cast<double>(row.step); }),
                      tableColumn("time", "s", steps, [](const StepStatistics& row) { return row.time; })}));
}

/// A line for each slice of a step.
std::string slicesOf(const StepStatistics& step, const ColumnUnits& units, const std::string& along) {
    StatisticsOfSteps rows;
    for (std::size_t i = 0; i < step.slices.size(); ++i) {
        auto& row = rows.emplace_back();
        row.step = static_cast<std::uint32_t>(i);
        row.names = step.names;
        row.values = step.slices[i];
    }
    const auto unit = unitOfColumn(along, units);
    const auto edge = [&](std::size_t off) {
        return [&step, off](const StepStatistics& row) { return step.sliceEdges[row.step + off]; };
    };
    return headOf(step) + "\n" +
           tableOf(rows, tableColumns(rows, units,
                                      {tableColumn(along + "_from", unit, rows, edge(0)),
                                       tableColumn(along + "_to", unit, rows, edge(1))}));
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
    some.sliceEdges = all.sliceEdges;
    for (const auto& slice : all.slices) {
        auto& kept = some.slices.emplace_back();
        for (const auto place : places) kept.push_back(slice[place]);
    }
    return some;
}

namespace {

std::string jsonSlices(const StepStatistics& statistics) {
    std::string slices;
    for (std::size_t i = 0; i < statistics.names.size(); ++i) {
        std::vector<double> values;
        for (const auto& slice : statistics.slices) values.push_back(slice[i]);
        slices +=
            fmt::format("{}{}: {}", i == 0 ? "" : ", ", jsonString(statistics.names[i]), jsonArray(values));
    }
    return fmt::format(", \"slice_edges\": {}, \"slices\": {{{}}}", jsonArray(statistics.sliceEdges), slices);
}

/// Calls `take` with the values of each row and, of a slice, its number.
template <class Take>
Status eachRow(const StatisticsOfSteps& steps, bool sliced, const Take& take) {
    for (const auto& step : steps) {
        if (!sliced) MOTE_RETURN_IF_ERROR(take(step, step.values, 0));
        for (std::size_t i = 0; sliced && i < step.slices.size(); ++i)
            MOTE_RETURN_IF_ERROR(take(step, step.slices[i], i));
    }
    return success();
}

}  // namespace

std::string jsonLine(const StepStatistics& statistics) {
    std::string line = fmt::format("{{\"step\": {}, \"iteration\": {}, \"time\": {}", statistics.step,
                                   statistics.iteration, exactNumber(statistics.time, "null"));
    for (std::size_t i = 0; i < statistics.names.size(); ++i)
        line += fmt::format(", {}: {}", jsonString(statistics.names[i]),
                            exactNumber(statistics.values[i], "null"));
    if (!statistics.slices.empty()) line += jsonSlices(statistics);
    return line + jsonNotes(statistics.notes) + "}\n";
}

std::string csvText(const StatisticsOfSteps& steps, const ColumnUnits& units, const std::string& along) {
    std::string text = "step,iteration,time [s]";
    const bool sliced = !along.empty();
    if (sliced) {
        text += ",slice";
        for (const auto* end : {"_from", "_to"})
            text += "," + csvField(withUnit(along + end, unitOfColumn(along, units)));
    }
    for (const auto& name : steps.front().names) text += "," + csvField(withUnit(name, unitOf(name, units)));
    text += "\n";
    static_cast<void>(
        eachRow(steps, sliced, [&](const StepStatistics& step, const auto& values, std::size_t slice) {
            text += fmt::format("{},{},{}", step.step, step.iteration, exactNumber(step.time, ""));
            if (sliced)
                text += fmt::format(",{},{},{}", slice, exactNumber(step.sliceEdges[slice], ""),
                                    exactNumber(step.sliceEdges[slice + 1], ""));
            for (const double value : values) text += "," + exactNumber(value, "");
            text += "\n";
            return success();
        }));
    return text;
}

Status writeNpy(const std::filesystem::path& path, const StatisticsOfSteps& steps, const ColumnUnits& units,
                const std::string& along) {
    std::vector<NpyField> fields{{"step", "<i8"}, {"iteration", "<i8"}, {"time", "<f8", "time [s]"}};
    const auto add = [&](const std::string& name, const std::string& unit) {
        auto title = withUnit(name, unit);
        fields.push_back({name, "<f8", title == name ? std::string() : std::move(title)});
    };
    const bool sliced = !along.empty();
    if (sliced) {
        fields.push_back({"slice", "<i8"});
        for (const auto* end : {"_from", "_to"}) add(along + end, unitOfColumn(along, units));
    }
    for (const auto& name : steps.front().names) add(name, unitOf(name, units));
    MOTE_ASSIGN_OR_RETURN(auto file, NpyRows::create(path, fields));
    MOTE_RETURN_IF_ERROR(
        eachRow(steps, sliced, [&](const StepStatistics& step, const auto& values, std::size_t slice) {
            const auto word = [](double value) { return std::bit_cast<std::uint64_t>(value); };
            std::vector<std::uint64_t> words{step.step, static_cast<std::uint64_t>(step.iteration),
                                             word(step.time)};
            if (sliced)
                words.insert(words.end(),
                             {slice, word(step.sliceEdges[slice]), word(step.sliceEdges[slice + 1])});
            for (const double value : values) words.push_back(word(value));
            return file.append(words);
        }));
    return file.publish();
}

std::string tableText(const StatisticsOfSteps& steps, const ColumnUnits& units, const std::string& along) {
    if (!along.empty()) {
        std::string text;
        for (const auto& step : steps) text += slicesOf(step, units, along);
        return text;
    }
    return steps.size() == 1 ? oneStep(steps.front(), units) : manySteps(steps, units);
}

namespace {

constexpr std::size_t barWidth = 40;
constexpr std::string_view shades = " .:-=+*#%@";

/// The counts of a step with its bins put together, as many of them at a time; at the end there may be fewer.
struct Coarse {
    std::size_t width = 1, height = 1;  ///< of the field: first column along, second up
    std::size_t across = 1;             ///< bins of the first column that were put together
    std::vector<double> counts;
    double greatest = 0.0;
};

Coarse coarse(const StepHistogram& histogram, std::size_t mostWide, std::size_t mostHigh) {
    const bool plane = histogram.edges.size() > 1;
    const auto wide = histogram.bins(0), high = plane ? histogram.bins(1) : 1;
    const auto across = (wide + mostWide - 1) / mostWide, up = (high + mostHigh - 1) / mostHigh;
    Coarse field{(wide + across - 1) / across, (high + up - 1) / up, across, {}, 0.0};
    field.counts.assign(field.width * field.height, 0.0);
    for (std::size_t i = 0; i < wide; ++i) {
        for (std::size_t j = 0; j < high; ++j) {
            const auto place = i / across * field.height + j / up;
            field.counts[place] += histogram.counts[i * high + j];
        }
    }
    for (const double count : field.counts) {
        if (std::isfinite(count)) field.greatest = std::max(field.greatest, count);
    }
    return field;
}

/// From 0 to `steps`: nothing only if there is nothing.
std::size_t shareOf(double count, double greatest, std::size_t steps) {
    if (!(count > 0.0) || !(greatest > 0.0)) return 0;
    return std::max<std::size_t>(
        1, static_cast<std::size_t>(std::lround(count / greatest * static_cast<double>(steps))));
}

std::string spanOf(const StepHistogram& histogram, std::size_t column, const ColumnUnits& units) {
    const auto& edges = histogram.edges[column];
    const auto unit = scaledUnit(std::max(std::abs(edges.front()), std::abs(edges.back())),
                                 unitOfColumn(histogram.columns[column], units));
    return fmt::format("{} from {} to {}{}{}", histogram.columns[column], shortNumber(edges.front(), unit),
                       shortNumber(edges.back(), unit), unit.name.empty() ? "" : " ", unit.name);
}

std::string headOf(const StepHistogram& histogram) {
    return fmt::format("step {}: {} particles{}", histogram.step, histogram.particles,
                       histogram.outside == 0.0
                           ? std::string()
                           : fmt::format(", a weight of {:.5g} outside", histogram.outside));
}

std::string bars(const StepHistogram& histogram, const ColumnUnits& units) {
    const auto field = coarse(histogram, shownBins(1)[0], 1);
    const auto& edges = histogram.edges[0];
    const auto unit = scaledUnit(std::max(std::abs(edges.front()), std::abs(edges.back())),
                                 unitOfColumn(histogram.columns[0], units));
    auto text = fmt::format("{}\n  {} {}\n", headOf(histogram), padLeft(histogram.columns[0], 12), unit.name);
    for (std::size_t i = 0; i < field.width; ++i) {
        text += fmt::format("  {:>12}  {:>12.5g}  {}\n", shortNumber(edges[i * field.across], unit),
                            field.counts[i],
                            std::string(shareOf(field.counts[i], field.greatest, barWidth), '#'));
    }
    return text + fmt::format("  {:>12}\n", shortNumber(edges.back(), unit));
}

std::string shaded(const StepHistogram& histogram, const ColumnUnits& units) {
    const auto most = shownBins(2);
    const auto field = coarse(histogram, most[0], most[1]);
    auto text = fmt::format("{}\nalong {}, up {}\n", headOf(histogram), spanOf(histogram, 0, units),
                            spanOf(histogram, 1, units));
    const auto rule = "+" + std::string(field.width, '-') + "+\n";
    text += rule;
    for (std::size_t j = field.height; j-- > 0;) {
        text += '|';
        for (std::size_t i = 0; i < field.width; ++i)
            text += shades[shareOf(field.counts[i * field.height + j], field.greatest, shades.size() - 1)];
        text += "|\n";
    }
    return text + rule;
}

}  // namespace

std::string jsonLine(const StepHistogram& histogram) {
    std::string edges, counts;
    for (const auto& each : histogram.edges) edges += (edges.empty() ? "" : ", ") + jsonArray(each);
    if (histogram.edges.size() == 1) {
        counts = jsonArray(histogram.counts);
    } else {
        const std::span<const double> all(histogram.counts);
        for (std::size_t i = 0; i < histogram.bins(0); ++i)
            counts +=
                (i == 0 ? "[" : ", ") + jsonArray(all.subspan(i * histogram.bins(1), histogram.bins(1)));
        counts += "]";
    }
    return fmt::format(
        "{{\"step\": {}, \"edges\": [{}], \"counts\": {}, \"particles\": {}, \"outside\": {}{}}}\n",
        histogram.step, edges, counts, histogram.particles, exactNumber(histogram.outside, "null"),
        jsonNotes(histogram.notes));
}

std::string csvHead(const std::vector<std::string>& columns, const ColumnUnits& units) {
    std::string text = "step";
    for (const auto& column : columns) {
        const auto unit = unitOfColumn(column, units);
        text += fmt::format(",{},{}", csvField(withUnit(column + "_from", unit)),
                            csvField(withUnit(column + "_to", unit)));
    }
    return text + ",count\n";
}

std::string csvText(const StepHistogram& histogram) {
    std::string text;
    const auto span = [&](std::size_t column, std::size_t bin) {
        const auto& edges = histogram.edges[column];
        return exactNumber(edges[bin], "") + "," + exactNumber(edges[bin + 1], "") + ",";
    };
    const auto high = histogram.edges.size() > 1 ? histogram.bins(1) : 1;
    for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
        text += fmt::format("{},{}{}{}\n", histogram.step, span(0, i / high),
                            histogram.edges.size() > 1 ? span(1, i % high) : "",
                            exactNumber(histogram.counts[i], ""));
    }
    return text;
}

std::array<std::uint32_t, 2> shownBins(std::size_t columns) {
    return columns == 1 ? std::array<std::uint32_t, 2>{40, 1} : std::array<std::uint32_t, 2>{72, 28};
}

std::string pictureText(const StepHistogram& histogram, const ColumnUnits& units) {
    return histogram.edges.size() == 1 ? bars(histogram, units) : shaded(histogram, units);
}

}  // namespace mote::client
