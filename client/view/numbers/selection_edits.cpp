// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/selection_edits.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "protocol/quantity/manifest_columns.h"
#include "protocol/quantity/plot_axes.h"
#include "protocol/quantity/quantity.h"
#include "protocol/scene/write_fields.h"

namespace mote::client {
namespace {

using PointMessages = google::protobuf::RepeatedPtrField<google::protobuf::ListValue>;

void assignPair(google::protobuf::ListValue& pair, double first, double second) {
    pair.add_values()->set_number_value(first);
    pair.add_values()->set_number_value(second);
}

void assignPoints(PointMessages& message, std::span<const glm::dvec2> points) {
    for (const auto& point : points) assignPair(*message.Add(), point.x, point.y);
}

/// Visits a selection, all that it holds and all that it names. What is not valid may name itself: each name
/// is followed once.
void visit(const proto::Selection& selection, const NamedSelectionMessages& named,
           std::set<std::string>& followed, const std::function<void(const proto::Selection&)>& see) {
    see(selection);
    for (const auto& part : selection.all()) visit(part, named, followed, see);
    for (const auto& part : selection.any()) visit(part, named, followed, see);
    if (selection.has_negated()) visit(selection.negated(), named, followed, see);
    if (selection.named().empty() || !followed.insert(selection.named()).second) return;
    for (const auto& each : named) {
        if (each.name() == selection.named()) visit(each.selection(), named, followed, see);
    }
}

/// Tells whether it is a list of alternatives, or of conditions, and nothing else.
bool isOnly(const proto::Selection& selection, bool any) {
    proto::Selection rest = selection;
    any ? rest.clear_any() : rest.clear_all();
    const int parts = any ? selection.any_size() : selection.all_size();
    return parts > 0 && rest.ByteSizeLong() == 0;
}

proto::Selection joined(const proto::Selection& first, const proto::Selection& second, bool any) {
    proto::Selection result;
    if (isOnly(first, any)) {
        result = first;
    } else {
        *(any ? result.add_any() : result.add_all()) = first;
    }
    *(any ? result.add_any() : result.add_all()) = second;
    return result;
}

std::string describeRange(const proto::Selection::Range& range) {
    if (range.has_min() && range.has_max())
        return fmt::format("{} {:.4g} to {:.4g}", range.column(), range.min(), range.max());
    if (range.has_min()) return fmt::format("{} from {:.4g}", range.column(), range.min());
    if (range.has_max()) return fmt::format("{} to {:.4g}", range.column(), range.max());
    return fmt::format("any {}", range.column());
}

std::string describeDensity(const proto::Selection::Density& density) {
    if (density.has_min() && density.has_max())
        return fmt::format("log density {:.3g} to {:.3g}", density.min(), density.max());
    if (density.has_min()) return fmt::format("log density from {:.3g}", density.min());
    if (density.has_max()) return fmt::format("log density to {:.3g}", density.max());
    return "any density";
}

/// "(a or b)"; a single one as it is.
std::string list(const google::protobuf::RepeatedPtrField<proto::Selection>& parts, std::string_view word) {
    std::vector<std::string> texts;
    for (const auto& part : parts) texts.push_back(describe(part));
    const auto text = fmt::format("{}", fmt::join(texts, word));
    return texts.size() > 1 ? "(" + text + ")" : text;
}

std::vector<std::string> conditionsOf(const proto::Selection& selection) {
    std::vector<std::string> texts;
    if (selection.nothing()) texts.emplace_back("no particle");
    if (!selection.named().empty()) texts.push_back(selection.named());
    for (const auto& range : selection.ranges()) texts.push_back(describeRange(range));
    if (selection.has_density()) texts.push_back(describeDensity(selection.density()));
    if (selection.has_polygon())
        texts.push_back(fmt::format("polygon in {}", fmt::join(selection.polygon().columns(), ", ")));
    if (selection.has_lasso())
        texts.push_back(fmt::format("lasso of {} corners", selection.lasso().points_size()));
    if (selection.has_outermost()) {
        const auto& outermost = selection.outermost();
        texts.push_back(fmt::format("outermost {:.3g}% in {}", 100.0 * outermost.share(), outermost.plane()));
    }
    if (!selection.ids().empty()) texts.push_back(fmt::format("{} ids", selection.ids_size()));
    if (!selection.all().empty()) texts.push_back(list(selection.all(), ", "));
    if (!selection.any().empty()) texts.push_back(list(selection.any(), " or "));
    if (selection.has_negated()) texts.push_back("not " + describe(selection.negated()));
    return texts;
}

}  // namespace

proto::Selection lassoOn(const Camera& camera, double aspect, const proto::Layer& layer,
                         const glm::dmat4& layerToWorld, std::span<const glm::dvec2> points) {
    proto::Selection selection;
    auto& lasso = *selection.mutable_lasso();
    *lasso.mutable_camera() = toProto(camera);
    lasso.set_aspect(aspect);
    writeTransform(layerToWorld, lasso.mutable_transform());
    const proto::Clip clip = saidClip(layer);
    if (!clip.planes().empty() || clip.has_box()) *lasso.mutable_clip() = clip;
    assignPoints(*lasso.mutable_points(), points);
    return selection;
}

void sayPlot(const proto::ParticlesManifest& plot, std::uint32_t step, bool madeHere,
             proto::Selection::Lasso& lasso) {
    if (plot.axes_size() < axesOfPlot) return;
    const auto run = mote::columnsOf(plot);
    proto::Selection::Lasso said;
    for (int i = 0; i < axesOfPlot; ++i) {
        const auto& axis = axisOf(plot, i, step);
        const auto& common = plot.axes(i);
        const bool own = axis.min() != common.min() || axis.max() != common.max();
        if ((own && !madeHere) || !mote::Quantity::make(axis.name(), run).ok()) return;
        said.add_axes(axis.name());
        assignPair(*said.add_bounds(), axis.min(), axis.max());
    }
    *lasso.mutable_axes() = said.axes();
    *lasso.mutable_bounds() = said.bounds();
}

proto::Selection polygonIn(const std::string& first, const std::string& second,
                           std::span<const glm::dvec2> points) {
    proto::Selection selection;
    auto& polygon = *selection.mutable_polygon();
    polygon.add_columns(first);
    polygon.add_columns(second);
    assignPoints(*polygon.mutable_points(), points);
    return selection;
}

proto::Selection reference(const std::string& name) {
    proto::Selection selection;
    selection.set_named(name);
    return selection;
}

proto::Selection combined(const proto::Selection& present, Combine how, const proto::Selection& gesture) {
    proto::Selection first = present, second = gesture;
    // Made in the same step, they are one selection of that step.
    const bool sameStep = present.has_step() && gesture.has_step() && present.step() == gesture.step();
    if (sameStep) {
        first.clear_step();
        second.clear_step();
    }
    if (how == Combine::without) {
        proto::Selection negated;
        *negated.mutable_negated() = second;
        second = negated;
    }
    auto result = joined(first, second, how == Combine::either);
    if (sameStep) result.set_step(present.step());
    return result;
}

std::string describe(const proto::Selection& selection) {
    const auto texts = conditionsOf(selection);
    const auto text = texts.empty() ? "all particles" : fmt::format("{}", fmt::join(texts, ", "));
    return selection.has_step() ? fmt::format("{} at step {}", text, selection.step()) : text;
}

std::string freshName(const NamedSelectionMessages& named, const std::string& wish) {
    const auto taken = [&](const std::string& name) {
        return std::ranges::any_of(named, [&](const auto& each) { return each.name() == name; });
    };
    std::string name = wish;
    for (int number = 2; taken(name); ++number) name = fmt::format("{} {}", wish, number);
    return name;
}

std::set<std::string> namesIn(const proto::Selection& selection, const NamedSelectionMessages& named) {
    std::set<std::string> names;
    visit(selection, named, names, [](const auto&) {});
    return names;
}

void renameIn(proto::Selection& selection, const std::string& from, const std::string& to) {
    if (selection.named() == from) selection.set_named(to);
    for (auto& part : *selection.mutable_all()) renameIn(part, from, to);
    for (auto& part : *selection.mutable_any()) renameIn(part, from, to);
    if (selection.has_negated()) renameIn(*selection.mutable_negated(), from, to);
}

std::set<std::string> columnsIn(const proto::Selection& selection, const NamedSelectionMessages& named) {
    std::set<std::string> columns, followed;
    visit(selection, named, followed, [&](const proto::Selection& part) {
        for (const auto& range : part.ranges()) columns.insert(range.column());
        columns.insert(part.polygon().columns().begin(), part.polygon().columns().end());
        columns.insert(part.lasso().axes().begin(), part.lasso().axes().end());
    });
    return columns;
}

bool dependsOnPlot(const proto::Selection& selection, const NamedSelectionMessages& named) {
    bool depends = false;
    std::set<std::string> followed;
    visit(selection, named, followed, [&](const proto::Selection& part) {
        depends |= part.has_density() || (part.has_lasso() && part.lasso().axes().empty());
    });
    return depends;
}

std::vector<glm::dvec2> cornersOf(const PointMessages& points) {
    std::vector<glm::dvec2> corners;
    for (const auto& point : points) {
        if (point.values_size() == 2)
            corners.emplace_back(point.values(0).number_value(), point.values(1).number_value());
    }
    return corners;
}

namespace {

constexpr double apart = 2.0;               // screen pixels between corners of a lasso, at least
constexpr std::size_t mostCorners = 10000;  // a message of these is small

}  // namespace

void PictureTool::setKind(Kind kind) {
    kind_ = kind;
    drawing_ = false;
    line_.clear();
}

PictureTool::Done PictureTool::move(const Mouse& mouse) {
    Done done;
    if (mouse.pressed && (mouse.picks || kind_ == Kind::pick)) {
        done.pick = mouse.at;
        return done;
    }
    if (mouse.pressed && kind_ == Kind::lasso) {
        drawing_ = true;
        line_.assign(1, mouse.at);
        return done;
    }
    if (!drawing_) return done;
    extend(mouse);
    if (mouse.held) return done;
    drawing_ = false;
    auto line = std::exchange(line_, {});
    if (line.size() >= 3) done.lasso = std::move(line);  // fewer surround nothing: a click
    return done;
}

void PictureTool::extend(const Mouse& mouse) {
    const glm::dvec2 way = (mouse.at - line_.back()) / mouse.pixel;
    if (std::hypot(way.x, way.y) >= apart && line_.size() < mostCorners) line_.push_back(mouse.at);
}

proto::Query endsOf(const std::string& dataset, const proto::ParticlesManifest& plot, std::uint32_t step,
                    const proto::Selection& selection) {
    proto::Query query;
    query.set_dataset(dataset);
    query.set_steps(fmt::format("{0}:{0}:1", step));
    *query.mutable_select() = selection;
    for (int i = 0; i < axesOfPlot; ++i) {
        for (const char* end : {"min_", "max_"})
            query.mutable_statistics()->add_names(end + axisOf(plot, i, step).name());
    }
    return query;
}

std::optional<Bounds> boxOf(const StepStatistics& ends, const proto::ParticlesManifest& plot) {
    constexpr double least = 0.01;
    Bounds box;
    if (ends.values.size() != 2 * std::size_t{axesOfPlot}) return std::nullopt;
    for (int i = 0; i < axesOfPlot; ++i) {
        const auto& axis = axisOf(plot, i, ends.step);
        const auto placeOf = [&](double value) {
            return 2.0 * (value - axis.min()) / (axis.max() - axis.min()) - 1.0;
        };
        const auto first = 2 * static_cast<std::size_t>(i);
        const double low = placeOf(ends.values[first]), high = placeOf(ends.values[first + 1]);
        if (!std::isfinite(low) || !std::isfinite(high)) return std::nullopt;
        const double room = std::max(0.5 * (least - (high - low)), 0.0);
        box.min[i] = std::max(low - room, plotBounds.min[i]);
        box.max[i] = std::min(high + room, plotBounds.max[i]);
        if (!(box.min[i] < box.max[i])) return std::nullopt;
    }
    return box;
}

}  // namespace mote::client
