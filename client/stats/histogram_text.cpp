// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/stats/histogram_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>

#include "client/shared/number_text.h"
#include "client/stats/json_notes.h"

namespace mote::client {
namespace {

constexpr std::size_t barWidth = 40;
constexpr std::string_view shades = " .:-=+*#%@";

template <class Numbers>
std::string jsonArray(const Numbers& numbers) {
    std::string text = "[";
    for (const double number : numbers) {
        if (text.size() > 1) text += ", ";
        text += exactNumber(number, "null");
    }
    return text + "]";
}

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

/// From 0 to `steps`: nothing only where there is nothing.
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
