// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/hybrid_controls.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>

#include "protocol/scene/hybrid_style.h"

namespace mote::client {
namespace {

std::array<float, 3> toFloats(const glm::dvec3& vector) {
    return {static_cast<float>(vector.x), static_cast<float>(vector.y), static_cast<float>(vector.z)};
}

glm::dvec3 toVector(const std::array<float, 3>& numbers) {
    return {numbers[0], numbers[1], numbers[2]};
}

/// Sliders may be a rounding error outside.
double share(float value) {
    return std::clamp(static_cast<double>(value), 0.0, 1.0);
}

Interval valuesOf(const proto::HybridManifest& manifest) {
    const double low = manifest.value_min(), high = manifest.value_max();
    return {low, high > low ? high : low + 1.0};
}

void writeLight(const HybridControls& controls, proto::Light& light) {
    assign(light.mutable_direction(), controls.light.direction());
    light.set_fixed(controls.fixedLight);
    light.set_ambient(share(controls.ambient));
    light.set_diffuse(share(controls.diffuse));
    light.set_specular(share(controls.specular));
}

void writeClip(const HybridControls& controls, proto::HybridStyle& style) {
    style.clear_clip_planes();
    for (const auto& plane : controls.clipPlanes) {
        auto& written = *style.add_clip_planes();
        assign(written.mutable_normal(), plane.normal.direction());
        written.set_distance(plane.distance);
    }
    style.clear_clip_box();
    if (!controls.clipBox) return;
    const glm::dvec3 min = toVector(controls.clipMin);
    const glm::dvec3 least = 1e-6 * (glm::abs(min) + 1.0);  // a box holds something
    assign(style.mutable_clip_box()->mutable_min(), min);
    assign(style.mutable_clip_box()->mutable_max(), glm::max(toVector(controls.clipMax), min + least));
}

}  // namespace

HybridControls::HybridControls() {
    read({});
}

std::vector<CurvePreset> HybridControls::presets(const proto::HybridManifest& manifest) {
    const Interval values = valuesOf(manifest);
    std::span<const std::uint64_t> histogram;
    if (!manifest.steps().empty()) {
        const auto& bins = manifest.steps(0).histogram();
        histogram = {bins.data(), static_cast<std::size_t>(bins.size())};
    }
    return presetsOf(manifest.value_unit(), {values.low, values.high}, histogram);
}

Bounds HybridControls::boundsOf(const proto::HybridManifest& manifest) {
    if (manifest.index_to_world_size() != 16 || manifest.source_size_size() != 3) return plotBounds;
    glm::dmat4 toWorld(1.0);
    for (int i = 0; i < 16; ++i) toWorld[i % 4][i / 4] = manifest.index_to_world(i);  // glm keeps columns
    const glm::dvec3 size(manifest.source_size(0), manifest.source_size(1), manifest.source_size(2));
    return Bounds{glm::dvec3(-0.5), size - 0.5}.transformed(toWorld);  // samples are cells' centres
}

void HybridControls::setDataset(const proto::HybridManifest& manifest) {
    const Interval values = valuesOf(manifest);
    const bool first = values_ == Interval{0.0, 0.0};
    const bool same = manifest.value_unit() == valuesUnit_ && values == values_;
    values_ = values;
    valuesUnit_ = manifest.value_unit();
    curve.setValues(values);
    if (same || (first && ownCurve_)) return;
    curve.take(presets(manifest).front());
    ownColorRange = false;
    colorRange = {static_cast<float>(values.low), static_cast<float>(values.high)};
    clipPlanes.clear();
    clipBox = false;
    const Bounds bounds = boundsOf(manifest);
    clipMin = toFloats(bounds.min);
    clipMax = toFloats(bounds.max);
}

glm::dvec3 HybridControls::color(double value) const {
    if (!curve.colors().empty()) return curve.color(value);
    const auto map = ColorMap::find(colorMap);
    const Interval ends = ownColorRange ? Interval{colorRange[0], colorRange[1]} : curve.extent();
    return map.ok() ? (*map)((value - ends.low) / (ends.high - ends.low)) : glm::dvec3(0.0);
}

void HybridControls::addClipPlane(const Bounds& bounds, const glm::dvec3& eye) {
    const glm::dvec3 away = bounds.center() - eye;
    if (clipPlanes.size() >= HybridStyle::mostClipPlanes || !(glm::length(away) > 0.0)) return;
    const auto normal = LightAngles::of(away);
    clipPlanes.push_back({normal, static_cast<float>(glm::dot(normal.direction(), bounds.center()))});
}

void HybridControls::write(proto::HybridStyle& style) const {
    curve.write(style);
    style.set_representation(representation);
    style.clear_color_map();
    style.clear_color_range();
    if (curve.colors().empty()) {
        style.set_color_map(colorMap);
        if (ownColorRange && colorRange[0] < colorRange[1]) {
            for (const float end : colorRange) style.add_color_range(end);
        }
    }
    style.set_point_shape(pointShape);
    style.set_point_opacity(share(pointOpacity));
    writeLight(*this, *style.mutable_light());
    writeClip(*this, style);
}

void HybridControls::read(const proto::HybridStyle& message) {
    const auto style = parseHybridStyle(message).value();
    curve.read(message);
    ownCurve_ = !message.curve().empty();
    values_ = {0.0, 0.0};
    representation = message.representation();
    colorMap = style.colorMap.name();
    ownColorRange = style.colorRange.has_value();
    if (style.colorRange) {
        colorRange = {static_cast<float>(style.colorRange->low), static_cast<float>(style.colorRange->high)};
    }
    pointShape = message.point_shape().empty() ? "gaussian" : message.point_shape();
    pointOpacity = static_cast<float>(style.pointOpacity);
    light = LightAngles::of(style.light.direction);
    fixedLight = style.light.fixed;
    ambient = static_cast<float>(style.light.ambient);
    diffuse = static_cast<float>(style.light.diffuse);
    specular = static_cast<float>(style.light.specular);
    clipPlanes.clear();
    for (const auto& plane : style.clipPlanes) {
        clipPlanes.push_back({LightAngles::of(plane.normal), static_cast<float>(plane.distance)});
    }
    clipBox = style.clipBox.has_value();
    if (!style.clipBox) return;
    clipMin = toFloats(style.clipBox->min);
    clipMax = toFloats(style.clipBox->max);
}

}  // namespace mote::client
