// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/annotation_bars.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <map>
#include <optional>
#include <string>

#include "protocol/quantity/manifest_columns.h"
#include "protocol/quantity/plot_axes.h"
#include "server/figures/color_bar.h"
#include "server/figures/projection.h"
#include "server/figures/quantity_text.h"
#include "server/figures/unit_text.h"

namespace mote::server {
namespace {

constexpr double margin = 1.0;        // em, from the picture's edges
constexpr double highest = 16.0;      // em
constexpr double lowest = 4.0;        // em
constexpr double barWidth = 0.9;      // em
constexpr double widestScale = 0.25;  // of the picture

struct Bar {
    AxisScale scale;
    std::string unit;
    RichText name;
    std::function<glm::dvec3(double)> color;  ///< linear RGB, by share
    std::string same;                         ///< of bars that would be alike, the same
};

/// What a density is told in: one over the product of the axes' units, each with the prefix that suits it.
/// Returns the factor from a weight over the plot's share of its box.
double densityUnit(const proto::ParticlesManifest& plot, std::uint32_t step, RichText& unit) {
    double volume = 1.0;
    std::map<std::pair<std::string, int>, int> powers;
    for (int a = 0; a < std::min(plot.axes_size(), axesOfPlot); ++a) {
        const auto& axis = axisOf(plot, a, step);
        const int prefix = prefixPower(axis.unit(), std::max(std::abs(axis.min()), std::abs(axis.max())));
        volume *= (axis.max() - axis.min()) / std::pow(10.0, prefix);
        if (axis.unit() != "1" && !axis.unit().empty()) ++powers[{axis.unit(), prefix}];
    }
    if (plot.weight_unit() == "C") unit = upright("C");
    const auto compoundUnit = [](const std::string& of) {
        return of.find_first_of("/ *") != std::string::npos;
    };
    std::vector<std::pair<std::pair<std::string, int>, int>> ordered(powers.begin(), powers.end());
    std::stable_partition(ordered.begin(), ordered.end(),
                          [&](const auto& of) { return !compoundUnit(of.first.first); });
    for (const auto& [of, power] : ordered) {
        const bool compound = compoundUnit(of.first);
        const RichText name = unitText(of.first, of.second);
        if (!unit.empty()) unit = unit + upright("\u2009");
        unit = unit + (compound ? upright("(") + name + upright(")") : name);
        unit.push_back({withMinusSign(std::to_string(-power)), false, Script::above});
    }
    return 1.0 / volume;
}

bool hasDensityRange(const Layer& layer) {
    return layer.particles() != nullptr && layer.particles()->densityRange.has_value();
}

/// With a range of its own also of what its colours would be beyond the plot's densities.
std::optional<Bar> densityBar(const proto::Manifest& manifest, const TransferFunction& transfer,
                              const Layer& layer) {
    const auto& plot = manifest.particles();
    RichText unit;
    const double factor = densityUnit(plot, layer.step, unit);
    const double decades = std::log(plot.density_max() / plot.density_min());
    const ValueRange& all = transfer.colorRange;  // of t
    const ValueRange shown =
        hasDensityRange(layer) ? all : ValueRange{std::max(all.low, 0.0), std::min(all.high, 1.0)};
    const double low = plot.density_min() * std::exp(shown.low * decades) * factor;
    const double high = plot.density_min() * std::exp(shown.high * decades) * factor;
    if (!(low > 0.0) || !(high > low) || !std::isfinite(high)) return std::nullopt;
    RichText name = upright(plot.weight_unit() == "C" ? "charge density" : "density");
    if (!unit.empty()) name = name + upright(" (") + unit + upright(")");
    return Bar{{low, high, true},
               "1",
               std::move(name),
               [transfer, shown](double share) {
                   return transfer.color(shown.low + share * (shown.high - shown.low));
               },
               ""};
}

std::optional<Bar> valueBar(const proto::Manifest& manifest, const TransferFunction& transfer) {
    const ValueRange range = transfer.colors.empty() ? transfer.colorRange : transfer.span;
    if (!(range.low < range.high)) return std::nullopt;
    const auto color = [transfer, range](double share) {
        return transfer.color(range.low + share * (range.high - range.low));
    };
    return Bar{{range.low, range.high}, manifest.hybrid().value_unit(), upright("value"), color, ""};
}

std::optional<Bar> columnBar(const Layer& layer, const LayerFacts& facts) {
    const auto& by = *layer.colorBy;
    std::optional<ValueRange> range = facts.colorRange ? facts.colorRange : by.range;
    for (const auto& column : facts.manifest->particles().columns()) {
        if (!range && column.name() == by.column) range = ValueRange{column.min(), column.max()};
    }
    if (!range || !(range->low < range->high)) return std::nullopt;
    return Bar{{range->low, range->high},
               unitOfQuantity(by.column, columnsOf(facts.manifest->particles())),
               quantityText(by.column),
               [map = by.colorMap](double share) { return map(share); },
               std::string(by.colorMap.name())};
}

std::vector<Bar> barsOf(const View& view, const std::vector<LayerFacts>& layers) {
    std::vector<Bar> bars;
    const auto add = [&](std::optional<Bar> bar, const std::string& same) {
        if (!bar) return;
        bar->same += same;
        const bool known = std::any_of(bars.begin(), bars.end(), [&](const Bar& other) {
            return other.same == bar->same && other.scale.low == bar->scale.low &&
                   other.scale.high == bar->scale.high && other.name == bar->name;
        });
        if (!known) bars.push_back(*std::move(bar));
    };
    for (std::size_t i = 0; i < layers.size(); ++i) {
        const auto& facts = layers[i];
        if (facts.manifest == nullptr || !(view.layers[i].opacity > 0.0)) continue;
        if (facts.transfer && facts.manifest->has_particles())
            add(densityBar(*facts.manifest, *facts.transfer, view.layers[i]),
                std::string(facts.transfer->colorMap.name()));
        if (facts.transfer && facts.manifest->has_hybrid())
            add(valueBar(*facts.manifest, *facts.transfer), std::string(facts.transfer->colorMap.name()));
        if (view.layers[i].colorBy) add(columnBar(view.layers[i], facts), "");
    }
    return bars;
}

/// A length of 1, 2 or 5 times a power of ten, not above another.
double roundLength(double most) {
    const double power = std::pow(10.0, std::floor(std::log10(most)));
    for (const double digit : {5.0, 2.0}) {
        if (digit * power <= most) return digit * power;
    }
    return power;
}

/// A unit of the metre, as a power of ten of it; nothing of another.
std::optional<int> metrePower(const std::string& unit) {
    static const std::map<std::string, int> powers{{"m", 0},   {"cm", -2}, {"mm", -3},      {"um", -6},
                                                   {"nm", -9}, {"km", 3},  {"\u00b5m", -6}, {"\u03bcm", -6}};
    const auto found = powers.find(unit);
    return found == powers.end() ? std::nullopt : std::optional(found->second);
}

RichText lengthText(double length, const std::string& unit) {
    const auto power = metrePower(unit);
    const double metres = power ? length * std::pow(10.0, *power) : length;
    const int prefix = power ? prefixPower("m", metres) : 0;
    const auto number = fmt::format("{:.6g}", metres / std::pow(10.0, prefix));
    const RichText written = power ? unitText("m", prefix) : unitText(unit, 0);
    return written.empty() ? upright(number) : upright(number + "\u2009") + written;
}

}  // namespace

void addColorBars(const View& view, const std::vector<LayerFacts>& layers, AnnotationRoom& room) {
    const auto& look = room.look();
    const auto bars = barsOf(view, layers);
    if (bars.empty()) return;
    const double each = room.picture().size().y / static_cast<double>(bars.size());
    const double height = std::min(highest * look.font, 0.7 * each);
    if (height < lowest * look.font) return;
    std::vector<PlotAxis> axes;
    double reach = 0.0;
    for (const auto& bar : bars) {
        auto axis = makeAxis(Side::right, bar.scale, bar.unit, bar.name, height, look, room.typeface());
        axes.push_back(axis.ok() ? *std::move(axis) : PlotAxis{Side::right, bar.scale, {}, {}});
        reach = std::max(reach, roomOf(axes.back(), look, room.typeface()));
    }
    const double right = room.picture().high.x - margin * look.font - reach;
    for (std::size_t i = 0; i < bars.size(); ++i) {
        const double middle = each * (static_cast<double>(i) + 0.5);
        const Box box{{right - barWidth * look.font, middle - 0.5 * height}, {right, middle + 0.5 * height}};
        const Box taken{box.low - 0.6 * look.font, {room.picture().high.x, box.high.y + 0.6 * look.font}};
        if (!room.free(quadOf(taken))) continue;
        addColorBar(box, axes[i], bars[i].color, look, room.typeface(), room.marks());
        room.take(quadOf(taken));
    }
}

void addScaleBar(const View& view, const std::vector<LayerFacts>& layers, AnnotationRoom& room) {
    const LayerFacts* found = nullptr;
    for (std::size_t i = 0; i < layers.size() && found == nullptr; ++i) {
        const bool world = layers[i].manifest != nullptr &&
                           (layers[i].manifest->has_hybrid() || layers[i].manifest->has_mesh());
        if (world && view.layers[i].opacity > 0.0) found = &layers[i];
    }
    if (found == nullptr) return;
    const auto& look = room.look();
    const Projection projection(view);
    const double pixel = projection.pixelSize(glm::length(view.camera.target - view.camera.eye));
    const double most = widestScale * room.picture().size().x * pixel;
    if (!(most > 0.0) || !std::isfinite(most)) return;
    const double length = roundLength(most), pixels = length / pixel;
    const glm::dvec2 left{margin * look.font, room.picture().high.y - margin * look.font - 0.5 * look.tick()};
    const glm::dvec2 right = left + glm::dvec2(pixels, 0.0), end(0.0, 0.5 * look.tick());
    const auto label =
        room.text(lengthText(length, found->manifest->hybrid().world_unit()),
                  0.5 * (left + right) - glm::dvec2(0.0, look.tick() + look.gap()), {0.5, 1.0});
    const Box taken{{left.x, boxAround(quadOf(label, room.typeface())).low.y}, right + end};
    if (!room.free(label) || !room.free(quadOf(taken))) return;
    for (const auto& line :
         {std::pair(left, right), std::pair(left - end, left + end), std::pair(right - end, right + end)})
        room.marks().push_back(LineMark{{line.first, line.second}, 2.0 * look.line, look.ink});
    room.put(label);
    room.take(quadOf(taken));
}

}  // namespace mote::server
