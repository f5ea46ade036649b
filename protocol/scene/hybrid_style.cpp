// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/hybrid_style.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <string_view>
#include <utility>

#include "protocol/scene/check.h"
#include "protocol/scene/style_kinds.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

constexpr double largest = 1e30;  // of a value, a place or a distance

template <class T, std::size_t count>
Result<T> parseName(const std::string& name, const std::array<std::pair<std::string_view, T>, count>& known,
                    std::string_view field) {
    std::string names;
    for (const auto& [one, value] : known) {
        if (one == name) return value;
        if (!one.empty()) names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", one);
    }
    return invalid(std::string(field), fmt::format("there are {}", names));
}

constexpr std::array<std::pair<std::string_view, HybridRepresentation>, 4> representations{
    {{"", HybridRepresentation::best},
     {"points", HybridRepresentation::points},
     {"residual", HybridRepresentation::residual},
     {"volume", HybridRepresentation::volume}}};

constexpr std::array<std::pair<std::string_view, PointShape>, 4> shapes{{{"", PointShape::gaussian},
                                                                         {"square", PointShape::square},
                                                                         {"disc", PointShape::disc},
                                                                         {"gaussian", PointShape::gaussian}}};

template <class T, std::size_t count>
std::string nameOf(T value, const std::array<std::pair<std::string_view, T>, count>& known) {
    const auto found = std::ranges::find(known, value, &std::pair<std::string_view, T>::second);
    return std::string(found->first);
}

Status parseCurve(const proto::HybridStyle& message, HybridStyle& style) {
    if (message.curve().empty()) return success();
    std::vector<Curve::Knot> knots;
    for (const auto& knot : message.curve()) knots.push_back({knot.value(), knot.opacity()});
    auto curve = Curve::create(std::move(knots), -largest, largest);
    if (!curve.ok()) return curve.error().within("curve");
    style.opacity = *std::move(curve);
    const bool colored = !message.curve(0).color().empty();
    for (int i = 0; i < message.curve_size(); ++i) {
        const auto at = fmt::format("curve[{}].color", i);
        if (message.curve(i).color().empty() == colored) {
            return invalid(at, "all knots of a curve have a color, or none");
        }
        if (!colored) continue;
        MOTE_ASSIGN_OR_RETURN(const auto color, checkColor(message.curve(i).color(), glm::dvec3(0.0), at));
        style.colors.push_back(color);
    }
    return success();
}

Status parseColors(const proto::HybridStyle& message, HybridStyle& style) {
    if (!message.color_map().empty()) {
        if (!style.colors.empty()) return invalid("colorMap", "is instead of the knots' colors");
        const auto map = ColorMap::find(message.color_map());
        if (!map.ok()) return map.error().within("colorMap");
        style.colorMap = *map;
    }
    if (message.color_range().empty()) return success();
    if (message.color_range_size() != 2) {
        return invalid("colorRange", fmt::format("2 values are needed, not {}", message.color_range_size()));
    }
    MOTE_ASSIGN_OR_RETURN(const auto low,
                          checkRange(message.color_range(0), -largest, largest, "colorRange[0]"));
    MOTE_ASSIGN_OR_RETURN(const auto high,
                          checkRange(message.color_range(1), -largest, largest, "colorRange[1]"));
    if (!(low < high)) return invalid("colorRange", "the second value must be the greater one");
    style.colorRange = ValueRange{low, high};
    return success();
}

Status parsePoints(const proto::HybridStyle& message, HybridStyle& style) {
    MOTE_ASSIGN_OR_RETURN(style.pointShape, parseName(message.point_shape(), shapes, "pointShape"));
    MOTE_ASSIGN_OR_RETURN(style.pointOpacity, checkRange(message.has_point_opacity() ? message.point_opacity()
                                                                                     : style.pointOpacity,
                                                         0.0, 1.0, "pointOpacity"));
    return success();
}

Result<HalfSpace> parsePlane(const proto::ClipPlane& message) {
    const auto normal = checkVector(message.normal(), 1e6, "normal");
    MOTE_RETURN_IF_ERROR(normal);
    MOTE_ASSIGN_OR_RETURN(const auto distance, checkRange(message.distance(), -largest, largest, "distance"));
    const double length = glm::length(*normal);
    if (!(length > 1e-6)) return invalid("normal", "a normal must not be zero");
    return HalfSpace{*normal / length, distance / length};
}

Result<Bounds> parseBox(const proto::ClipBox& message) {
    const auto min = checkVector(message.min(), largest, "min");
    MOTE_RETURN_IF_ERROR(min);
    const auto max = checkVector(message.max(), largest, "max");
    MOTE_RETURN_IF_ERROR(max);
    for (int axis = 0; axis < 3; ++axis) {
        if (!((*min)[axis] < (*max)[axis])) {
            return invalid(fmt::format("max[{}]", axis), "must lie above the box's min");
        }
    }
    return Bounds{*min, *max};
}

Status parseClips(const proto::HybridStyle& message, HybridStyle& style) {
    if (message.clip_planes_size() > HybridStyle::mostClipPlanes) {
        return invalid("clipPlanes", fmt::format("a layer has at most {} clip planes, not {}",
                                                 HybridStyle::mostClipPlanes, message.clip_planes_size()));
    }
    for (int i = 0; i < message.clip_planes_size(); ++i) {
        const auto plane = parsePlane(message.clip_planes(i));
        if (!plane.ok()) return plane.error().within(fmt::format("clipPlanes[{}]", i));
        style.clipPlanes.push_back(*plane);
    }
    if (!message.has_clip_box()) return success();
    const auto box = parseBox(message.clip_box());
    if (!box.ok()) return box.error().within("clipBox");
    style.clipBox = *box;
    return success();
}

void writeTransfer(const HybridStyle& style, proto::HybridStyle& message) {
    const auto knots = style.opacity ? style.opacity->knots() : std::vector<Curve::Knot>();
    for (std::size_t i = 0; i < knots.size(); ++i) {
        auto& added = *message.add_curve();
        added.set_value(knots[i].x);
        added.set_opacity(knots[i].y);
        if (!style.colors.empty()) writeColor(style.colors[i], added.mutable_color());
    }
    if (style.colors.empty()) message.set_color_map(std::string(style.colorMap.name()));
    if (!style.colorRange) return;
    message.add_color_range(style.colorRange->low);
    message.add_color_range(style.colorRange->high);
}

void writeClips(const HybridStyle& style, proto::HybridStyle& message) {
    for (const auto& plane : style.clipPlanes) {
        auto& added = *message.add_clip_planes();
        writeVector(plane.normal, added.mutable_normal());
        added.set_distance(plane.distance);
    }
    if (!style.clipBox) return;
    writeVector(style.clipBox->min, message.mutable_clip_box()->mutable_min());
    writeVector(style.clipBox->max, message.mutable_clip_box()->mutable_max());
}

}  // namespace

Result<HybridStyle> parseHybridStyle(const proto::HybridStyle& message) {
    HybridStyle style;
    const auto representation = parseName(message.representation(), representations, "representation");
    MOTE_RETURN_IF_ERROR(representation);
    style.representation = *representation;
    MOTE_RETURN_IF_ERROR(parseCurve(message, style));
    MOTE_RETURN_IF_ERROR(parseColors(message, style));
    MOTE_RETURN_IF_ERROR(parsePoints(message, style));
    const auto light = parseLight(message.light(), Light{.ambient = 0.25, .diffuse = 0.75, .specular = 0.25});
    if (!light.ok()) return light.error().within("light");
    if (light->shadow) return invalid("light.shadow", "volumes cast no shadows");
    style.light = *light;
    MOTE_RETURN_IF_ERROR(parseClips(message, style));
    return style;
}

void writeStyle(const HybridStyle& style, const glm::dvec3&, proto::Layer& layer) {
    auto& message = *layer.mutable_hybrid();
    message.set_representation(nameOf(style.representation, representations));
    writeTransfer(style, message);
    message.set_point_shape(nameOf(style.pointShape, shapes));
    message.set_point_opacity(style.pointOpacity);
    *message.mutable_light() = toProto(style.light);
    writeClips(style, message);
}

}  // namespace mote
