// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/annotate.h"

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/mat4x4.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/mote_check.h"
#include "protocol/quantity/manifest_columns.h"
#include "protocol/quantity/plot_axes.h"
#include "protocol/scene/fields/facts.h"
#include "protocol/scene/space/length_unit.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/view.h"
#include "server/figures/annotation_room.h"
#include "server/figures/annotation_words.h"
#include "server/figures/box_edges.h"
#include "server/figures/plot_axis.h"
#include "server/figures/projection.h"
#include "server/figures/quantity_text.h"
#include "server/figures/ticks.h"

namespace mote::server {
namespace {

/// The box around a particle plot as a picture shows it: its outermost edges and those that lie behind the
/// plot, with ticks and labels beside an outermost one of each axis; or, if none is in the picture, beside
/// one that lies behind.
struct PlotBox {
    struct Axis {
        std::string name;  ///< a column or derived quantity
        std::string unit;
        double min = 0.0, max = 1.0;

        bool operator==(const Axis&) const = default;
    };
    std::array<Axis, 3> axes;
    glm::dmat4 transform{1.0};  ///< layer space, in which it is plotBounds, to world space

    bool operator==(const PlotBox&) const = default;
};

constexpr int mostBoxTicks = 7;
constexpr double leastLength = 2.5, leastBehind = 4.0;  // em, of an edge that gets labels
constexpr double behind = 0.4;                          // opacity of edges that lie behind the plot
constexpr double samePlace = 0.5;                       // pixels

/// An edge with its ticks and the labels that have room.
struct LabelledEdge {
    std::vector<LineMark> ticks;
    std::vector<TextMark> labels;
    std::optional<TextMark> title;
    double worth = 0.0;  ///< of several, the greatest is drawn
};

/// Where a text of an axis stands, so far out from the edge.
glm::dvec2 anchorFor(const glm::dvec2& out) {
    // The whole way to a side as soon as it is mostly that way: labels beside an edge line up.
    const glm::dvec2 way = glm::clamp(1.4 * out, -1.0, 1.0);
    return 0.5 * (1.0 - way);
}

class AxisLabels {
  public:
    AxisLabels(const PlotBox::Axis& axis, const BoxEdge& edge, const glm::dvec2& middle,
               const Projection& projection, const AnnotationRoom& room)
        : axis_(axis), edge_(edge), projection_(projection), room_(room), look_(room.look()) {
        const glm::dvec2 from = pixel(edge.from), to = pixel(edge.to);
        length_ = glm::length(to - from);
        long_ = length_ >= (edge.kind == BoxEdge::Kind::outline ? leastLength : leastBehind) * look_.font;
        if (!long_) return;
        way_ = (to - from) / length_;
        out_ = glm::dvec2(way_.y, -way_.x);
        if (glm::dot(out_, from - middle) < 0.0) out_ = -out_;
    }

    std::optional<LabelledEdge> make() const {
        if (!long_) return std::nullopt;
        for (int most = mostBoxTicks; most > 1; --most) {
            const auto ticks = linearTicks(value(edge_.from), value(edge_.to), axis_.unit, most);
            if (!ticks.ok()) return std::nullopt;
            if (auto made = withTicks(*ticks); made) return made;
        }
        return std::nullopt;
    }

  private:
    glm::dvec2 pixel(double share) const { return projection_.pixel(edge_.at(share)); }
    double value(double share) const { return axis_.min + share * (axis_.max - axis_.min); }
    double shareOf(double value) const { return (value - axis_.min) / (axis_.max - axis_.min); }

    LineMark tickAt(const glm::dvec2& at, double length) const {
        return {{at, at + length * out_}, look_.line, look_.ink};
    }

    /// Nothing if labels of the axis would lie over each other.
    std::optional<LabelledEdge> withTicks(const Ticks& ticks) const {
        LabelledEdge made;
        std::vector<Quad> own;
        for (const double minor : ticks.minor)
            made.ticks.push_back(tickAt(pixel(shareOf(minor)), 0.55 * look_.tick()));
        double reach = 0.0;
        for (const auto& tick : ticks.major) {
            const glm::dvec2 at = pixel(shareOf(tick.value));
            made.ticks.push_back(tickAt(at, look_.tick()));
            const auto label =
                room_.text(tick.label, at + (look_.tick() + look_.gap()) * out_, anchorFor(out_));
            const Quad quad = quadOf(label, room_.typeface());
            const Quad apart = quadOf(Box{boxAround(quad)}.grown(0.2 * look_.font));
            if (std::any_of(own.begin(), own.end(), [&](const Quad& other) { return meet(apart, other); }))
                return std::nullopt;
            own.push_back(quad);
            for (const auto& corner : quad) reach = std::max(reach, glm::dot(corner - at, out_));
            if (room_.isFree(quad)) made.labels.push_back(label);
        }
        made.title = titleOf(ticks, reach + look_.gap(), own);
        made.worth = static_cast<double>(made.labels.size()) /
                     std::max<double>(1.0, static_cast<double>(ticks.major.size()));
        made.worth += (made.title ? 1.0 : 0.0) + 0.1 * out_.y - 0.05 * out_.x;
        return made;
    }

    /// Along the edge, beyond the labels, if there is room.
    std::optional<TextMark> titleOf(const Ticks& ticks, double away, const std::vector<Quad>& own) const {
        double angle = std::atan2(way_.y, way_.x);
        // Read from below, or, of a steep edge, from the right.
        constexpr double steep = std::numbers::pi / 3.0;
        if (angle > steep) angle -= std::numbers::pi;
        if (angle <= steep - std::numbers::pi) angle += std::numbers::pi;
        const glm::dvec2 up(std::sin(angle), -std::cos(angle));
        const bool above = glm::dot(up, out_) > 0.0;
        const double lift = above ? Typeface::descent * look_.font : 0.0;
        for (const double share : {0.5, 0.35, 0.65, 0.2, 0.8}) {
            const glm::dvec2 at = pixel(edge_.from + share * (edge_.to - edge_.from));
            const auto title = room_.text(ticks.title(quantityText(axis_.name)), at + (away + lift) * out_,
                                          {0.5, above ? 1.0 : 0.0}, angle);
            const Quad quad = quadOf(title, room_.typeface());
            const bool over =
                std::any_of(own.begin(), own.end(), [&](const Quad& other) { return meet(quad, other); });
            if (!over && room_.isFree(quad)) return title;
        }
        return std::nullopt;
    }

    const PlotBox::Axis& axis_;
    const BoxEdge& edge_;
    const Projection& projection_;
    const AnnotationRoom& room_;
    const PlotLook& look_;
    double length_ = 0.0;  // pixels, of what is in the picture
    bool long_ = false;    // enough for labels
    glm::dvec2 way_{0.0};  // along the edge
    glm::dvec2 out_{0.0};  // away from the box
};

/// Whether an edge lies where one of the outline does, as the far ones do of a plot seen along an axis.
bool hidden(const BoxEdge& edge, const BoxInPicture& box, const Projection& projection) {
    const auto same = [](const glm::dvec2& a, const glm::dvec2& b) {
        return glm::distance(a, b) < samePlace;
    };
    const auto low = projection.pixel(edge.at(edge.from)), high = projection.pixel(edge.at(edge.to));
    if (same(low, high)) return true;
    return std::any_of(box.edges.begin(), box.edges.end(), [&](const BoxEdge& other) {
        if (other.kind != BoxEdge::Kind::outline || other.axis != edge.axis || other.from >= other.to)
            return false;
        const auto from = projection.pixel(other.at(other.from)), to = projection.pixel(other.at(other.to));
        return (same(low, from) && same(high, to)) || (same(low, to) && same(high, from));
    });
}

void addEdges(const BoxInPicture& box, const Projection& projection, AnnotationRoom& room) {
    for (const auto& edge : box.edges) {
        if (edge.kind == BoxEdge::Kind::front || edge.from >= edge.to) continue;
        const bool outline = edge.kind == BoxEdge::Kind::outline;
        if (!outline && hidden(edge, box, projection)) continue;
        Ink ink = room.look().ink;
        if (!outline) ink.opacity *= behind;
        room.marks().push_back(
            LineMark{{projection.pixel(edge.at(edge.from)), projection.pixel(edge.at(edge.to))},
                     room.look().line,
                     ink});
    }
}

/// Of an axis that is seen end on there are no labels, and none if the eye is in the box. A label that
/// would lie beyond the picture's edge, or over another, is left out.
void addPlotBox(const PlotBox& plot, const View& view, AnnotationRoom& room) {
    const Projection projection(view);
    const auto box = boxInPicture(projection.worldToEye() * plot.transform, projection, room.picture());
    addEdges(box, projection, room);
    if (!box.outlined) return;
    for (int axis = 0; axis < 3; ++axis) {
        std::optional<LabelledEdge> best;
        for (const auto& edge : box.edges) {
            if (edge.axis != axis || edge.kind == BoxEdge::Kind::front || edge.from >= edge.to) continue;
            auto made =
                AxisLabels(plot.axes[static_cast<std::size_t>(axis)], edge, box.middle, projection, room)
                    .make();
            if (!made || made->labels.empty()) continue;
            // Before what lies inside, where the plot may be, whatever lies outside.
            if (edge.kind == BoxEdge::Kind::outline) made->worth += 10.0;
            if (!best || made->worth > best->worth) best = std::move(made);
        }
        if (!best) continue;
        for (auto& tick : best->ticks) room.marks().push_back(std::move(tick));
        for (const auto& label : best->labels) room.put(label);
        if (best->title) room.put(*best->title);
    }
}

// The bars of a frame: of colours, and of scale. Functions that add marks.

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
    return layer.particles() != nullptr && !layer.particles()->volume().density_range().empty();
}

/// Which colour what has a density is drawn in: where there is no volume, that of the points.
std::function<glm::dvec3(double)> colorByDensity(const LayerFacts& facts) {
    return [transfer = *facts.transfer, points = facts.points](double t) {
        return points && !(transfer.opacity(t) > 0.0) ? *points : transfer.color(t);
    };
}

/// The same of layers in which densities have the same colours.
std::string sameDensityColors(const LayerFacts& facts) {
    std::string map(facts.transfer->colorMap.name());
    if (!facts.points) return map;
    return fmt::format("{} {} {} {}", map, facts.points->x, facts.points->y, facts.points->z);
}

/// With a range of its own also of what its colours would be beyond the plot's densities.
std::optional<Bar> densityBar(const LayerFacts& facts, const Layer& layer) {
    const auto& plot = facts.manifest->particles();
    const TransferFunction& transfer = *facts.transfer;
    RichText unit;
    const double factor = densityUnit(plot, layer.step, unit);
    const double decades = std::log(plot.density_max() / plot.density_min());
    const ValueRange& all = transfer.colorRange;                // of t
    const auto [first, last] = std::minmax(all.low, all.high);  // the map may go from dense to thin
    const ValueRange shown =
        hasDensityRange(layer) ? all : ValueRange{std::max(first, 0.0), std::min(last, 1.0)};
    const double low = plot.density_min() * std::exp(shown.low * decades) * factor;
    const double high = plot.density_min() * std::exp(shown.high * decades) * factor;
    if (!(low > 0.0) || !(high > low) || !std::isfinite(high)) return std::nullopt;
    RichText name = upright(plot.weight_unit() == "C" ? "charge density" : "density");
    if (!unit.empty()) name = name + upright(" (") + unit + upright(")");
    return Bar{{low, high, true},
               "1",
               std::move(name),
               [color = colorByDensity(facts), shown](double share) {
                   return color(shown.low + share * (shown.high - shown.low));
               },
               ""};
}

bool hasColorRange(const Layer& layer) {
    return layer.hybrid() != nullptr && !layer.hybrid()->color_range().empty();
}

/// Of the values that there are, unless the view says the range.
std::optional<Bar> valueBar(const proto::Manifest& manifest, const TransferFunction& transfer,
                            const Layer& layer) {
    ValueRange range = transfer.colors.empty() ? transfer.colorRange : transfer.span;
    const ValueRange values{manifest.hybrid().value_min(), manifest.hybrid().value_max()};
    if (!hasColorRange(layer) && values.low < values.high) {
        const double seen = transfer.opacity.knots().front().x;  // colours may begin below
        range = {std::max({range.low, values.low, seen}), std::min(range.high, values.high)};
    }
    if (!(range.low < range.high)) return std::nullopt;
    const auto color = [transfer, range](double share) {
        return transfer.color(range.low + share * (range.high - range.low));
    };
    return Bar{{range.low, range.high}, manifest.hybrid().value_unit(), upright("value"), color, ""};
}

std::optional<Bar> columnBar(const Layer& layer, const LayerFacts& facts) {
    const auto& by = *layer.colorBy;
    std::optional<ValueRange> range = facts.colorRange ? facts.colorRange : colorRangeOf(by);
    for (const auto& column : facts.manifest->particles().columns()) {
        if (!range && column.name() == by.column()) range = ValueRange{column.min(), column.max()};
    }
    if (!range || !(range->low < range->high)) return std::nullopt;
    return Bar{{range->low, range->high},
               unitOfQuantity(by.column(), columnsOf(facts.manifest->particles())),
               quantityText(by.column()),
               [map = colorMapOf(by)](double share) { return map(share); },
               by.color_map()};
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
            add(densityBar(facts, view.layers[i]), sameDensityColors(facts));
        if (facts.transfer && facts.manifest->has_hybrid())
            add(valueBar(*facts.manifest, *facts.transfer, view.layers[i]),
                std::string(facts.transfer->colorMap.name()));
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

RichText lengthText(double length, const std::string& unit) {
    const auto metre = metresOf(unit);
    const double metres = length * metre.value_or(1.0);
    const int prefix = metre ? prefixPower("m", metres) : 0;
    const auto number = fmt::format("{:.6g}", metres / std::pow(10.0, prefix));
    const RichText written = metre ? unitText("m", prefix) : unitText(unit, 0);
    return written.empty() ? upright(number) : upright(number + "\u2009") + written;
}

/// On the right, one above another: for each volume that is seen and for each column that colours points, one
/// that several layers share once. A plot's densities have their true scale: weight over what its axes span.
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
        if (!room.isFree(quadOf(taken))) continue;
        addColorBar(box, axes[i], bars[i].color, look, room.typeface(), room.marks());
        room.take(quadOf(taken));
    }
}

/// By what all lengths are multiplied; nothing where directions differ in that.
std::optional<double> lengthFactor(const glm::dmat4& transform) {
    constexpr double alike = 1e-9;
    const glm::dmat3 linear(transform);
    const glm::dmat3 squares = glm::transpose(linear) * linear;
    const double square = (squares[0][0] + squares[1][1] + squares[2][2]) / 3.0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            if (!(std::abs(squares[i][j] - (i == j ? square : 0.0)) <= alike * square)) return std::nullopt;
        }
    }
    return std::sqrt(square);
}

/// What a length of 1 in the world is in a unit.
struct WorldLength {
    double factor;  ///< world units of a unit
    std::string unit;
};

/// By a view in metres, or by its first layer that is no plot and lies in units of its own, moved, turned or
/// magnified; nothing where directions differ in lengths.
std::optional<WorldLength> worldLength(const View& view, const std::vector<LayerFacts>& layers) {
    if (view.metres) {
        const auto factor = lengthFactor(glm::scale(glm::dmat4(1.0), view.metres->stretch));
        return factor ? std::optional(WorldLength{*factor, "m"}) : std::nullopt;
    }
    for (std::size_t i = 0; i < layers.size(); ++i) {
        const auto& manifest = layers[i].manifest;
        const bool world = manifest != nullptr && (manifest->has_hybrid() || manifest->has_mesh());
        if (!world || !(view.layers[i].opacity > 0.0)) continue;
        const auto factor = lengthFactor(view.layers[i].transform);
        if (factor) return WorldLength{*factor, worldUnit(*manifest)};
    }
    return std::nullopt;
}

/// In the lower left corner, if there is a length for it: a round one of at most a quarter of the picture's
/// width, true at the depth of the camera's target.
void addScaleBar(const View& view, const std::vector<LayerFacts>& layers, AnnotationRoom& room) {
    const auto world = worldLength(view, layers);
    if (!world) return;
    const auto& look = room.look();
    const Projection projection(view);
    const double pixel =
        projection.pixelSize(glm::length(view.camera.target - view.camera.eye)) / world->factor;
    const double most = widestScale * room.picture().size().x * pixel;
    if (!(most > 0.0) || !std::isfinite(most)) return;
    const double length = roundLength(most), pixels = length / pixel;
    const glm::dvec2 left{margin * look.font, room.picture().high.y - margin * look.font - 0.5 * look.tick()};
    const glm::dvec2 right = left + glm::dvec2(pixels, 0.0), end(0.0, 0.5 * look.tick());
    const auto label =
        room.text(lengthText(length, world->unit),
                  0.5 * (left + right) - glm::dvec2(0.0, look.tick() + look.gap()), {0.5, 1.0});
    const Box taken{{left.x, boxAround(quadOf(label, room.typeface())).low.y}, right + end};
    if (!room.isFree(label) || !room.isFree(quadOf(taken))) return;
    for (const auto& line :
         {std::pair(left, right), std::pair(left - end, left + end), std::pair(right - end, right + end)})
        room.marks().push_back(LineMark{{line.first, line.second}, 2.0 * look.line, look.ink});
    room.put(label);
    room.take(quadOf(taken));
}

constexpr double haloOpacity = 0.7;

PlotLook lookOf(const View& view) {
    const auto& annotations = *view.annotations;
    const glm::dvec3 standsOut(isLight(view.background) ? 0.0 : 1.0);
    const glm::dvec3 color = colorOf(annotations, annotations.kColorFieldNumber).value_or(standsOut);
    PlotLook look;
    look.font = fontPixels(annotations, view.width, view.height, view.scale);
    look.line = 0.075 * look.font;
    look.ink = {linearToSrgb(glm::clamp(color, 0.0, 1.0))};
    look.paper = linearToSrgb(glm::clamp(view.background, 0.0, 1.0));
    look.halo = {look.paper, haloOpacity};
    return look;
}

/// One for each plot that is seen, however many layers show it: a film shows two steps at once.
std::vector<PlotBox> boxesOf(const View& view, const std::vector<LayerFacts>& layers) {
    std::vector<PlotBox> boxes;
    for (std::size_t i = 0; i < layers.size(); ++i) {
        const Layer& layer = view.layers[i];
        const bool plot =
            layers[i].manifest != nullptr && layers[i].manifest->particles().axes_size() >= axesOfPlot;
        if (!plot || !(layer.opacity > 0.0)) continue;
        const Bounds shown = layers[i].shown.value_or(plotBounds);
        PlotBox box{{}, glm::scale(glm::translate(layer.transform, shown.center()), 0.5 * shown.size())};
        for (int axis = 0; axis < 3; ++axis) {
            const auto& of = axisOf(layers[i].manifest->particles(), axis, layer.step);
            const auto value = [&](double place) {
                return of.min() + 0.5 * (place + 1.0) * (of.max() - of.min());
            };
            box.axes[static_cast<std::size_t>(axis)] = {of.name(), of.unit(), value(shown.min[axis]),
                                                        value(shown.max[axis])};
        }
        if (std::find(boxes.begin(), boxes.end(), box) == boxes.end()) boxes.push_back(std::move(box));
    }
    return boxes;
}

}  // namespace

Marks annotate(const View& view, const std::vector<LayerFacts>& layers) {
    MOTE_CHECK(view.annotations && layers.size() == view.layers.size());
    const auto& annotations = *view.annotations;
    AnnotationRoom room(view.width, view.height, lookOf(view));
    // What has its own place goes first; ticks take what is left.
    if (!annotations.title().empty()) addTitle(annotations.title(), room);
    if (annotations.labels()) addWords(view, layers, room);
    if (annotations.color_bar()) addColorBars(view, layers, room);
    if (annotations.scale_bar()) addScaleBar(view, layers, room);
    if (annotations.axes()) {
        for (const auto& box : boxesOf(view, layers)) addPlotBox(box, view, room);
    }
    return std::move(room.marks());
}

}  // namespace mote::server
