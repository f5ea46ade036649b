// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/selection.h"

#include <fmt/format.h>
#include <google/protobuf/struct.pb.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/vec2.hpp>
#include <span>
#include <string_view>
#include <vector>

#include "protocol/base/check.h"
#include "protocol/quantity/plot_axes.h"
#include "protocol/quantity/quantity.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

constexpr double mostPlaceScale = 1e30;  // of places in a view in metres

using PointListMessage = google::protobuf::RepeatedPtrField<google::protobuf::ListValue>;

bool isNumber(const google::protobuf::Value& value) {
    return value.kind_case() == google::protobuf::Value::kNumberValue;
}

/// Two numbers of the list `field`. That is named only where there is something to say of it: lists are long.
Result<glm::dvec2> parsePair(const google::protobuf::ListValue& pair, std::string_view field, int index,
                             double limit) {
    if (pair.values_size() != 2 || !isNumber(pair.values(0)) || !isNumber(pair.values(1)))
        return invalid(fmt::format("{}[{}]", field, index), "two numbers are needed");
    glm::dvec2 numbers(0.0);
    for (int i = 0; i < 2; ++i) {
        const double value = pair.values(i).number_value();
        if (!(value >= -limit && value <= limit))
            return checkRange(value, -limit, limit, fmt::format("{}[{}][{}]", field, index, i)).error();
        numbers[i] = value;
    }
    return numbers;
}

Result<std::vector<glm::dvec2>> parsePoints(const PointListMessage& points, std::size_t least,
                                            std::size_t most, double limit) {
    const auto count = static_cast<std::size_t>(points.size());
    if (count < least) return invalid("points", fmt::format("at least {} are needed, not {}", least, count));
    if (count > most) return invalid("points", fmt::format("there may be at most {}, not {}", most, count));
    std::vector<glm::dvec2> result;
    result.reserve(count);
    for (int i = 0; i < points.size(); ++i) {
        MOTE_ASSIGN_OR_RETURN(const auto point, parsePair(points[i], "points", i, limit));
        result.push_back(point);
    }
    return result;
}

void writePair(double first, double second, PointListMessage* message) {
    auto& pair = *message->Add();
    pair.add_values()->set_number_value(first);
    pair.add_values()->set_number_value(second);
}

void writePoints(std::span<const glm::dvec2> points, PointListMessage* message) {
    message->Reserve(static_cast<int>(points.size()));
    for (const auto& point : points) writePair(point.x, point.y, message);
}

constexpr double largestCorner = 1e30;    // of a corner: products of two stay far from overflow
constexpr double farthest = 1e6;          // of a lasso's corner, pictures
constexpr double farthestBound = 1e300;   // of a plot's axis: its length stays finite
constexpr double thinnest = 1.0 / 16384;  // picture, width over height

Status checkBound(double value, std::string_view field) {
    if (std::isfinite(value)) return success();
    return invalid(std::string(field), "a bound is a finite number; where there is none it is left out");
}

/// The bounds of a message with optional min and max, into a value of both.
template <class Message, class Value>
Status readBounds(const Message& message, Value& value) {
    if (message.has_min()) {
        MOTE_RETURN_IF_ERROR(checkBound(message.min(), "min"));
        value.min = message.min();
    }
    if (message.has_max()) {
        MOTE_RETURN_IF_ERROR(checkBound(message.max(), "max"));
        value.max = message.max();
    }
    if (value.min <= value.max) return success();
    return invalid("max", fmt::format("lies below the min: {} < {}", value.max, value.min));
}

Result<Selection::Range> parseRange(const proto::Selection::Range& message) {
    Selection::Range range;
    MOTE_ASSIGN_OR_RETURN(range.column, checkColumnName(message.column(), "column"));
    MOTE_RETURN_IF_ERROR(readBounds(message, range));
    return range;
}

Result<Selection::Density> parseDensity(const proto::Selection::Density& message) {
    if (message.has_min()) MOTE_RETURN_IF_ERROR(checkRange(message.min(), 0.0, 1.0, "min"));
    if (message.has_max()) MOTE_RETURN_IF_ERROR(checkRange(message.max(), 0.0, 1.0, "max"));
    Selection::Density density;
    MOTE_RETURN_IF_ERROR(readBounds(message, density));
    return density;
}

Result<Selection::Polygon> parsePolygon(const proto::Selection::Polygon& message) {
    if (message.columns_size() != 2)
        return invalid("columns", fmt::format("two names are needed, not {}", message.columns_size()));
    Selection::Polygon polygon;
    MOTE_ASSIGN_OR_RETURN(polygon.first, checkColumnName(message.columns(0), "columns[0]"));
    MOTE_ASSIGN_OR_RETURN(polygon.second, checkColumnName(message.columns(1), "columns[1]"));
    if (polygon.first == polygon.second)
        return invalid("columns[1]", fmt::format("\"{}\" is given twice", polygon.first));
    MOTE_ASSIGN_OR_RETURN(polygon.points,
                          parsePoints(message.points(), 3, Selection::maxPolygonPoints, largestCorner));
    return polygon;
}

/// The plot in which a lasso was drawn; none where it says none.
Result<std::vector<Selection::PlotAxis>> parsePlot(const proto::Selection::Lasso& message) {
    std::vector<Selection::PlotAxis> plot;
    if (message.axes().empty() && message.bounds().empty()) return plot;
    const auto three = [](int count, const char* field) -> Status {
        if (count == axesOfPlot) return success();
        return invalid(field, fmt::format("a plot has {}, not {}", axesOfPlot, count));
    };
    MOTE_RETURN_IF_ERROR(three(message.axes_size(), "axes"));
    MOTE_RETURN_IF_ERROR(three(message.bounds_size(), "bounds"));
    for (int i = 0; i < axesOfPlot; ++i) {
        auto column = checkColumnName(message.axes(i), fmt::format("axes[{}]", i));
        MOTE_RETURN_IF_ERROR(column);
        MOTE_ASSIGN_OR_RETURN(const auto ends, parsePair(message.bounds(i), "bounds", i, farthestBound));
        if (!(ends.x < ends.y))
            return invalid(fmt::format("bounds[{}]", i), "the second value must be the greater one");
        plot.push_back({*std::move(column), ends.x, ends.y});
    }
    return plot;
}

Result<Selection::Lasso> parseLasso(const proto::Selection::Lasso& message) {
    Selection::Lasso lasso;
    if (!message.has_camera()) return invalid("camera", "a lasso needs the camera of its picture");
    const auto camera = parseCamera(message.camera());
    MOTE_RETURN_IF_ERROR(camera, "camera");
    lasso.camera = *camera;
    MOTE_ASSIGN_OR_RETURN(lasso.aspect, checkRange(message.aspect(), thinnest, 1.0 / thinnest, "aspect"));
    MOTE_ASSIGN_OR_RETURN(lasso.transform, parseTransform(message.transform(), mostPlaceScale));
    MOTE_ASSIGN_OR_RETURN(lasso.points,
                          parsePoints(message.points(), 3, Selection::maxPolygonPoints, farthest));
    MOTE_ASSIGN_OR_RETURN(lasso.plot, parsePlot(message));
    if (!message.has_clip()) return lasso;
    auto clip = parseClip(message.clip());
    MOTE_RETURN_IF_ERROR(clip, "clip");
    lasso.clip = *std::move(clip);
    return lasso;
}

Result<Selection::Outermost> parseOutermost(const proto::Selection::Outermost& message) {
    const auto& plane = message.plane();
    if (plane != "x" && plane != "y" && plane != "z")
        return invalid("plane", "there are \"x\", \"y\" and \"z\"");
    MOTE_ASSIGN_OR_RETURN(const auto share, checkRange(message.share(), 0.0, 1.0, "share"));
    return Selection::Outermost{plane[0], share};
}

}  // namespace

namespace {

constexpr int maxNamed = 64;

/// Reads one tree, and counts what it holds before it takes memory for it.
class Reader {
  public:
    explicit Reader(const NamedSelectionMessages& named) : named_(named) {}

    Result<Selection> read(const proto::Selection& message, int depth) {
        if (depth > Selection::maxDepth)
            return invalid(
                "", fmt::format("there are more than {} selections in each other", Selection::maxDepth));
        Selection selection;
        MOTE_RETURN_IF_ERROR(readRanges(message, selection));
        MOTE_RETURN_IF_ERROR(readParts(message, selection));
        MOTE_RETURN_IF_ERROR(readIds(message, selection));
        if (message.has_step()) selection.step = message.step();
        if (message.nothing()) {
            MOTE_RETURN_IF_ERROR(count(1, "nothing"));
            selection.nothing = true;
        }
        MOTE_RETURN_IF_ERROR(readList(message.all(), "all", depth, selection.all));
        MOTE_RETURN_IF_ERROR(readList(message.any(), "any", depth, selection.any));
        if (message.has_negated()) {
            auto negated = readInner(message.negated(), depth);
            MOTE_RETURN_IF_ERROR(negated, "not");
            selection.negated.push_back(*std::move(negated));
        }
        MOTE_RETURN_IF_ERROR(readNamed(message.named(), depth, selection));
        return selection;
    }

  private:
    Status count(std::size_t conditions, std::string_view field) {
        conditions_ += conditions;
        if (conditions_ <= std::size_t{Selection::maxConditions}) return success();
        return invalid(std::string(field),
                       fmt::format("a selection has at most {} conditions in all", Selection::maxConditions));
    }
    Status countValues(std::size_t values, std::string_view field) {
        values_ += values;
        if (values_ <= Selection::maxValues) return success();
        return invalid(std::string(field),
                       fmt::format("a selection has at most {} ids and points in all", Selection::maxValues));
    }

    Status readRanges(const proto::Selection& message, Selection& selection) {
        MOTE_RETURN_IF_ERROR(count(static_cast<std::size_t>(message.ranges_size()), "ranges"));
        for (int i = 0; i < message.ranges_size(); ++i) {
            auto range = parseRange(message.ranges(i));
            MOTE_RETURN_IF_ERROR(range, fmt::format("ranges[{}]", i));
            selection.ranges.push_back(*std::move(range));
        }
        return success();
    }

    template <class Message, class Value>
    Status readPart(bool there, const Message& message, Result<Value> (*parse)(const Message&),
                    std::string_view field, std::optional<Value>& value) {
        if (!there) return success();
        MOTE_RETURN_IF_ERROR(count(1, field));
        auto parsed = parse(message);
        MOTE_RETURN_IF_ERROR(parsed, field);
        value = *std::move(parsed);
        return success();
    }

    Status readParts(const proto::Selection& message, Selection& selection) {
        MOTE_RETURN_IF_ERROR(
            readPart(message.has_density(), message.density(), parseDensity, "density", selection.density));
        MOTE_RETURN_IF_ERROR(countValues(static_cast<std::size_t>(message.polygon().points_size()) +
                                             static_cast<std::size_t>(message.lasso().points_size()),
                                         message.has_polygon() ? "polygon.points" : "lasso.points"));
        MOTE_RETURN_IF_ERROR(
            readPart(message.has_polygon(), message.polygon(), parsePolygon, "polygon", selection.polygon));
        MOTE_RETURN_IF_ERROR(
            readPart(message.has_lasso(), message.lasso(), parseLasso, "lasso", selection.lasso));
        return readPart(message.has_outermost(), message.outermost(), parseOutermost, "outermost",
                        selection.outermost);
    }

    Status readIds(const proto::Selection& message, Selection& selection) {
        if (message.ids().empty()) return success();
        MOTE_RETURN_IF_ERROR(count(1, "ids"));
        MOTE_RETURN_IF_ERROR(countValues(static_cast<std::size_t>(message.ids_size()), "ids"));
        auto& ids = selection.ids;
        ids.assign(message.ids().begin(), message.ids().end());
        std::sort(ids.begin(), ids.end());
        ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
        return success();
    }

    Result<Selection> readInner(const proto::Selection& message, int depth) {
        MOTE_RETURN_IF_ERROR(count(1, ""));
        return read(message, depth + 1);
    }

    Status readList(const google::protobuf::RepeatedPtrField<proto::Selection>& messages,
                    std::string_view field, int depth, std::vector<Selection>& selections) {
        for (int i = 0; i < messages.size(); ++i) {
            auto selection = readInner(messages[i], depth);
            MOTE_RETURN_IF_ERROR(selection, fmt::format("{}[{}]", field, i));
            selections.push_back(*std::move(selection));
        }
        return success();
    }

    /// What a name stands for takes its place, or joins the other conditions.
    Status readNamed(const std::string& name, int depth, Selection& selection) {
        if (name.empty()) return success();
        const auto found =
            std::find_if(named_.begin(), named_.end(), [&](const auto& one) { return one.name() == name; });
        if (found == named_.end()) return invalid("named", notThere(name));
        if (std::find(open_.begin(), open_.end(), name) != open_.end())
            return invalid("named", fmt::format("the selection \"{}\" holds itself", name));
        open_.push_back(name);
        const bool alone = selection.everything();
        MOTE_RETURN_IF_ERROR(count(1, "named"));
        auto meant = read(found->selection(), alone ? depth : depth + 1);
        if (!meant.ok()) {
            const auto& error = meant.error();
            return invalid("named", error.where == "named"
                                        ? error.message
                                        : fmt::format("in \"{}\": {}", name, error.toString()));
        }
        open_.pop_back();
        if (alone)
            selection = *std::move(meant);
        else
            selection.all.push_back(*std::move(meant));
        return success();
    }

    std::string notThere(const std::string& name) const {
        constexpr int shown = 8;
        std::string names;
        for (int i = 0; i < std::min(named_.size(), shown); ++i)
            names += fmt::format("{}\"{}\"", i == 0 ? "" : ", ", named_[i].name().substr(0, 64));
        if (named_.size() > shown) names += fmt::format(" and {} more", named_.size() - shown);
        return fmt::format("there is no selection \"{}\"; {}", name.substr(0, 64),
                           names.empty() ? "none has a name here" : "there are " + names);
    }

    const NamedSelectionMessages& named_;
    std::vector<std::string_view> open_;  ///< names that are being read
    std::size_t conditions_ = 0, values_ = 0;
};

Status checkName(const NamedSelectionMessages& named, int index) {
    constexpr std::size_t longest = 256;  // bytes
    const auto& name = named[index].name();
    if (name.empty()) return invalid("name", "a selection of a view needs a name");
    if (name.size() > longest) return invalid("name", fmt::format("is longer than {} bytes", longest));
    for (int i = 0; i < index; ++i) {
        if (named[i].name() == name) return invalid("name", fmt::format("\"{}\" is given twice", name));
    }
    return success();
}

}  // namespace

Result<Selection> parseSelection(const proto::Selection& message, const NamedSelectionMessages& named) {
    return Reader(named).read(message, 1);
}

Result<Selection> parseSelection(const proto::Selection& message) {
    return parseSelection(message, NamedSelectionMessages());
}

Result<std::vector<NamedSelection>> parseNamedSelections(const NamedSelectionMessages& named) {
    if (named.size() > maxNamed)
        return invalid("", fmt::format("a view has at most {} of them, not {}", maxNamed, named.size()));
    std::vector<NamedSelection> selections;
    std::size_t values = 0;
    for (int i = 0; i < named.size(); ++i) {
        MOTE_RETURN_IF_ERROR(checkName(named, i), fmt::format("[{}]", i));
        auto selection = parseSelection(named[i].selection(), named);
        MOTE_RETURN_IF_ERROR(selection, fmt::format("[{}].selection", i));
        values += valueCount(*selection);
        if (values > Selection::maxValues)
            return invalid(
                fmt::format("[{}].selection", i),
                fmt::format("all together have more than {} ids and points", Selection::maxValues));
        selections.push_back({named[i].name(), *std::move(selection)});
    }
    return selections;
}

namespace {

template <class Value, class Message>
void writeBounds(const Value& value, Message& message) {
    if (std::isfinite(value.min)) message.set_min(value.min);
    if (std::isfinite(value.max)) message.set_max(value.max);
}

void write(const Selection::Polygon& polygon, proto::Selection::Polygon& message) {
    message.add_columns(polygon.first);
    message.add_columns(polygon.second);
    writePoints(polygon.points, message.mutable_points());
}

void write(const Selection::Lasso& lasso, proto::Selection::Lasso& message) {
    *message.mutable_camera() = toProto(lasso.camera);
    message.set_aspect(lasso.aspect);
    writeTransform(lasso.transform, message.mutable_transform());
    writePoints(lasso.points, message.mutable_points());
    if (lasso.clip) *message.mutable_clip() = *lasso.clip;
    for (const auto& axis : lasso.plot) {
        message.add_axes(axis.column);
        writePair(axis.min, axis.max, message.mutable_bounds());
    }
}

void write(const Selection& selection, proto::Selection& message) {
    for (const auto& range : selection.ranges) {
        auto& added = *message.add_ranges();
        added.set_column(range.column);
        writeBounds(range, added);
    }
    if (selection.density) writeBounds(*selection.density, *message.mutable_density());
    if (selection.polygon) write(*selection.polygon, *message.mutable_polygon());
    if (selection.lasso) write(*selection.lasso, *message.mutable_lasso());
    if (selection.outermost) {
        message.mutable_outermost()->set_plane(std::string(1, selection.outermost->plane));
        message.mutable_outermost()->set_share(selection.outermost->share);
    }
    message.mutable_ids()->Add(selection.ids.begin(), selection.ids.end());
    if (selection.step) message.set_step(*selection.step);
    if (selection.nothing) message.set_nothing(true);
    for (const auto& inner : selection.all) write(inner, *message.add_all());
    for (const auto& inner : selection.any) write(inner, *message.add_any());
    for (const auto& inner : selection.negated) write(inner, *message.mutable_negated());
}

}  // namespace

bool Selection::operator==(const Selection& other) const {
    return ranges == other.ranges && density == other.density && polygon == other.polygon &&
           lasso == other.lasso && outermost == other.outermost && ids == other.ids && step == other.step &&
           all == other.all && any == other.any && negated == other.negated && nothing == other.nothing;
}

std::size_t valueCount(const Selection& selection) {
    std::size_t count = selection.ids.size();
    if (selection.polygon) count += selection.polygon->points.size();
    if (selection.lasso) count += selection.lasso->points.size();
    for (const auto* const list : {&selection.all, &selection.any, &selection.negated}) {
        for (const auto& inner : *list) count += valueCount(inner);
    }
    return count;
}

proto::Selection toProto(const Selection& selection) {
    proto::Selection message;
    write(selection, message);
    return message;
}

}  // namespace mote
