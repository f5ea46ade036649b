// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/selection_parts.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "protocol/quantity/quantity.h"
#include "protocol/scene/check.h"
#include "protocol/scene/point_list.h"
#include "protocol/scene/transform.h"

namespace mote {
namespace {

constexpr double largestCorner = 1e30;    // of a corner: products of two stay far from overflow
constexpr double farthest = 1e6;          // of a lasso's corner, pictures
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

}  // namespace

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

Result<Selection::Lasso> parseLasso(const proto::Selection::Lasso& message) {
    Selection::Lasso lasso;
    if (!message.has_camera()) return invalid("camera", "a lasso needs the camera of its picture");
    const auto camera = parseCamera(message.camera());
    MOTE_RETURN_IF_ERROR(camera, "camera");
    lasso.camera = *camera;
    MOTE_ASSIGN_OR_RETURN(lasso.aspect, checkRange(message.aspect(), thinnest, 1.0 / thinnest, "aspect"));
    MOTE_ASSIGN_OR_RETURN(lasso.transform, parseTransform(message.transform()));
    MOTE_ASSIGN_OR_RETURN(lasso.points,
                          parsePoints(message.points(), 3, Selection::maxPolygonPoints, farthest));
    return lasso;
}

Result<Selection::Outermost> parseOutermost(const proto::Selection::Outermost& message) {
    const auto& plane = message.plane();
    if (plane != "x" && plane != "y" && plane != "z")
        return invalid("plane", "there are \"x\", \"y\" and \"z\"");
    MOTE_ASSIGN_OR_RETURN(const auto share, checkRange(message.share(), 0.0, 1.0, "share"));
    return Selection::Outermost{plane[0], share};
}

}  // namespace mote
