// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/hybrid_style.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <string_view>
#include <utility>

#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/style_kinds.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

template <class T, std::size_t count>
T valueOf(const std::string& name, const std::array<std::pair<std::string_view, T>, count>& known) {
    return std::ranges::find(known, std::string_view(name), &std::pair<std::string_view, T>::first)->second;
}

constexpr std::array<std::pair<std::string_view, HybridRepresentation>, 4> representations{
    {{"", HybridRepresentation::best},
     {"points", HybridRepresentation::points},
     {"residual", HybridRepresentation::residual},
     {"volume", HybridRepresentation::volume}}};

constexpr std::array<std::pair<std::string_view, PointShape>, 3> shapes{
    {{"square", PointShape::square}, {"disc", PointShape::disc}, {"gaussian", PointShape::gaussian}}};

template <class T, std::size_t count>
std::string nameOf(T value, const std::array<std::pair<std::string_view, T>, count>& known) {
    const auto found = std::ranges::find(known, value, &std::pair<std::string_view, T>::second);
    return std::string(found->first);
}

Status parseCurve(const proto::HybridStyle& message, HybridStyle& style) {
    if (message.curve().empty()) return success();
    std::vector<Curve::Knot> knots;
    const bool colored = !message.curve(0).color().empty();
    for (int i = 0; i < message.curve_size(); ++i) {
        const auto& knot = message.curve(i);
        knots.push_back({knot.value(), knot.opacity()});
        if (knot.color().empty() == colored)
            return invalid(fmt::format("curve[{}].color", i), "all knots of a curve have a color, or none");
        if (colored) style.colors.push_back(readColor(knot.color()));
    }
    style.opacity = Curve::create(std::move(knots), -Curve::largest, Curve::largest).value();
    return success();
}

Status parseColors(const proto::HybridStyle& message, HybridStyle& style) {
    if (!message.color_map().empty()) {
        if (!style.colors.empty()) return invalid("colorMap", "is instead of the knots' colors");
        style.colorMap = ColorMap::find(message.color_map()).value();
    }
    if (message.color_range().empty()) return success();
    style.colorRange = ValueRange{message.color_range(0), message.color_range(1)};
    if (style.colorRange->low < style.colorRange->high) return success();
    return invalid("colorRange", "the second value must be the greater one");
}

Result<HalfSpace> parsePlane(const proto::ClipPlane& message) {
    const glm::dvec3 normal = readVector(message.normal());
    const double length = glm::length(normal);
    if (!(length > 1e-6)) return invalid("normal", "a normal must not be zero");
    return HalfSpace{normal / length, message.distance() / length};
}

Result<Bounds> parseBox(const proto::ClipBox& message) {
    const Bounds box{readVector(message.min()), readVector(message.max())};
    for (int axis = 0; axis < 3; ++axis) {
        if (!(box.min[axis] < box.max[axis]))
            return invalid(fmt::format("max[{}]", axis), "must lie above the box's min");
    }
    return box;
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

Result<HybridStyle> parseHybridStyle(const proto::HybridStyle& said) {
    auto filled = said;
    auto& light = *filled.mutable_light();
    if (!light.has_ambient()) light.set_ambient(0.25);
    if (!light.has_diffuse()) light.set_diffuse(0.75);
    if (!light.has_specular()) light.set_specular(0.25);
    MOTE_ASSIGN_OR_RETURN(const auto message, resolved(std::move(filled)));
    if (message.light().shadow()) return invalid("light.shadow", "volumes cast no shadows");
    HybridStyle style;
    style.representation = valueOf(message.representation(), representations);
    style.pointShape = valueOf(message.point_shape(), shapes);
    style.pointOpacity = message.point_opacity();
    style.light = lightOf(message.light());
    MOTE_RETURN_IF_ERROR(parseCurve(message, style));
    MOTE_RETURN_IF_ERROR(parseColors(message, style));
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
