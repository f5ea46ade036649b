// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/particles_style.h"

#include <algorithm>
#include <cmath>

#include "protocol/scene/check.h"
#include "protocol/scene/log_density.h"
#include "protocol/scene/mix_curve.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/style_kinds.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

// Most of the log densities as points, the dense end as a volume that lets the eye in, a soft seam between.
// The opacity is level above the seam, so that no points are left there to cover the core.
const std::vector<Curve::Knot>& defaultVolumeKnots() {
    static const std::vector<Curve::Knot> knots{{0.62, 0.0}, {0.82, 0.12}};
    return knots;
}

Result<Curve> parseVolumeCurve(const proto::VolumeStyle& message) {
    std::vector<Curve::Knot> knots;
    for (const auto& knot : message.curve()) knots.push_back({knot.density(), knot.opacity()});
    auto curve = Curve::create(knots.empty() ? defaultVolumeKnots() : std::move(knots));
    return curve.ok() ? curve : Result<Curve>(curve.error().within("volume.curve"));
}

Result<Curve> parsePointCurve(const proto::PointsStyle& message, const Curve& volume) {
    const bool linked = !message.has_linked() || message.linked();
    if (linked && !message.curve().empty()) {
        return Error{ErrorCode::invalidArgument, "points.curve",
                     "a point curve needs \"linked\": false; linked points follow the volume's curve"};
    }
    if (linked) return linkedFraction(volume);
    std::vector<Curve::Knot> knots;
    for (const auto& knot : message.curve()) knots.push_back({knot.density(), knot.fraction()});
    auto curve = Curve::create(std::move(knots));
    return curve.ok() ? curve : Result<Curve>(curve.error().within("points.curve"));
}

/// Whether the points give way to the volume, as they do where a view says nothing of them.
bool isLinked(const ParticlesStyle& style) {
    return style.pointFraction == linkedFraction(style.volumeOpacity);
}

}  // namespace

TransferFunction ParticlesStyle::transfer() const {
    return {.opacity = volumeOpacity,
            .opacityLength = opacityLength,
            .fade = LogDensity::fade,
            .colorMap = colorMap,
            .span = {-LogDensity::fade, 1.0}};
}

double defaultPointOpacity(std::uint64_t particles) {
    constexpr double ofFew = 0.25, few = 4e6;
    const auto count = static_cast<double>(particles);
    return count <= few ? ofFew : -std::expm1(std::log1p(-ofFew) * few / count);
}

Curve linkedFraction(const Curve& volumeOpacity) {
    const double most = volumeOpacity.maximum();
    auto knots = volumeOpacity.knots();
    for (auto& knot : knots) knot.y = most > 0.0 ? std::clamp(1.0 - knot.y / most, 0.0, 1.0) : 1.0;
    return Curve::create(std::move(knots)).value();
}

Result<ParticlesStyle> parseParticlesStyle(const proto::ParticlesStyle& message) {
    const auto& points = message.points();
    auto volume = parseVolumeCurve(message.volume());
    MOTE_RETURN_IF_ERROR(volume);
    MOTE_ASSIGN_OR_RETURN(auto fraction, parsePointCurve(points, *volume));
    const auto& mapName = message.volume().color_map();
    const auto map = ColorMap::find(mapName.empty() ? ColorMap::defaultName : std::string_view(mapName));
    if (!map.ok()) return map.error().within("volume.colorMap");
    MOTE_ASSIGN_OR_RETURN(const auto opacity,
                          checkRange(points.has_opacity() ? points.opacity() : defaultPointOpacity(0), 0.0,
                                     1.0, "points.opacity"));
    MOTE_ASSIGN_OR_RETURN(const auto size, checkRange(points.has_size_pixels() ? points.size_pixels() : 1.0,
                                                      0.1, 64.0, "points.sizePixels"));
    MOTE_ASSIGN_OR_RETURN(
        const auto color,
        checkColor(points.color(), srgbToLinear(glm::dvec3(1.0, 0.85, 0.6)), "points.color"));
    return ParticlesStyle{*std::move(volume),
                          *map,
                          std::move(fraction),
                          std::min(opacity, ParticlesStyle::opacityLimit),
                          size,
                          color,
                          !points.has_opacity()};
}

void writeStyle(const ParticlesStyle& style, const glm::dvec3&, proto::Layer& layer) {
    auto& volume = *layer.mutable_particles()->mutable_volume();
    for (const auto& knot : style.volumeOpacity.knots()) {
        auto& added = *volume.add_curve();
        added.set_density(knot.x);
        added.set_opacity(knot.y);
    }
    volume.set_color_map(std::string(style.colorMap.name()));
    auto& points = *layer.mutable_particles()->mutable_points();
    points.set_linked(isLinked(style));
    for (const auto& knot : points.linked() ? std::vector<Curve::Knot>() : style.pointFraction.knots()) {
        auto& added = *points.add_curve();
        added.set_density(knot.x);
        added.set_fraction(knot.y);
    }
    if (!style.opacityByPlot) points.set_opacity(style.pointOpacity);
    points.set_size_pixels(style.pointSize);
    writeColor(style.pointColor, points.mutable_color());
}

void visitFields(ParticlesStyle& style, const ParticlesStyle& other, FieldVisitor& visitor) {
    visitCurve(visitor, style.volumeOpacity, other.volumeOpacity);
    // Linked to what lies between the volumes they would jump where one of these is nowhere opaque.
    visitCurve(visitor, style.pointFraction, other.pointFraction);
    visitor.word(style.colorMap == other.colorMap);
    visitor.word(style.opacityByPlot == other.opacityByPlot);
    if (!style.opacityByPlot && !other.opacityByPlot) visitor.number(style.pointOpacity, other.pointOpacity);
    visitor.pixels(style.pointSize, other.pointSize);
    visitor.vector(style.pointColor, other.pointColor);
}

}  // namespace mote
