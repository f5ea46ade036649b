// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/particles_style.h"

#include <algorithm>
#include <cmath>

#include "protocol/scene/field_visitor.h"
#include "protocol/scene/fields/facts.h"
#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/log_density.h"
#include "protocol/scene/mix.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/write_fields.h"

namespace mote {
namespace {

// Most of the log densities as points, the dense end as a volume that lets the eye in, a soft seam between.
// The opacity is level above the seam, so that no points are left there to cover the core.
const std::vector<Curve::Knot>& defaultVolumeKnots() {
    static const std::vector<Curve::Knot> knots{{0.62, 0.0}, {0.82, ParticlesStyle::fullOpacity}};
    return knots;
}

// Of points of a plot of which nothing is known; sRGB-encoded.
constexpr double unknownOpacity = 0.25;
constexpr glm::dvec3 usualColor(1.0, 0.85, 0.6);

Result<std::optional<ValueRange>> parseDensityRange(const proto::VolumeStyle& message) {
    const auto& range = message.density_range();
    if (range.empty()) return std::optional<ValueRange>();
    const bool valid = range.size() == 2 && std::isfinite(range[1]) && range[0] > 0.0 && range[0] < range[1];
    if (!valid) {
        return Error{ErrorCode::invalidArgument, "volume.densityRange",
                     "there must be two densities above 0, ascending"};
    }
    return std::optional(ValueRange{range[0], range[1]});
}

Curve volumeCurve(const proto::VolumeStyle& message) {
    std::vector<Curve::Knot> knots;
    for (const auto& knot : message.curve()) knots.push_back({knot.density(), knot.opacity()});
    return Curve::create(knots.empty() ? defaultVolumeKnots() : std::move(knots)).value();
}

Result<Curve> parsePointCurve(const proto::PointsStyle& message, const Curve& volume) {
    if (message.linked() && !message.curve().empty())
        return invalid("points.curve",
                       "a point curve needs \"linked\": false; linked points follow the volume's curve");
    if (message.linked()) return linkedFraction(volume);
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
    auto made = transferOf(volumeOpacity, colorMap);
    made.colorRange = colorRange;
    return made;
}

TransferFunction ParticlesStyle::transferOf(const Curve& volumeOpacity, const ColorMap& colorMap) {
    return {.opacity = volumeOpacity,
            .opacityLength = opacityLength,
            .fade = LogDensity::fade,
            .colorMap = colorMap,
            .span = {-LogDensity::fade, 1.0}};
}

Curve linkedFraction(const Curve& volumeOpacity) {
    const double most = volumeOpacity.maximum();
    auto knots = volumeOpacity.knots();
    for (auto& knot : knots) knot.y = most > 0.0 ? std::clamp(1.0 - knot.y / most, 0.0, 1.0) : 1.0;
    return Curve::create(std::move(knots)).value();
}

Result<ParticlesStyle> parseParticlesStyle(const proto::ParticlesStyle& said) {
    MOTE_ASSIGN_OR_RETURN(const auto message, resolved(said));
    const auto& points = message.points();
    auto volume = volumeCurve(message.volume());
    MOTE_ASSIGN_OR_RETURN(auto fraction, parsePointCurve(points, volume));
    MOTE_ASSIGN_OR_RETURN(const auto densities, parseDensityRange(message.volume()));
    const double opacity = points.has_opacity() ? points.opacity() : unknownOpacity;
    return ParticlesStyle{
        .volumeOpacity = std::move(volume),
        .colorMap = ColorMap::find(message.volume().color_map()).value(),
        .pointFraction = std::move(fraction),
        .pointOpacity = std::min(opacity, ParticlesStyle::opacityLimit),
        .pointSize = lengthOf(points, points.kSizePixelsFieldNumber),
        .pointColor = colorOf(points, points.kColorFieldNumber).value_or(srgbToLinear(usualColor)),
        .curveByPlot = message.volume().curve().empty() && points.linked(),
        .opacityByPlot = !points.has_opacity(),
        .sizeByPlot = !points.has_size_pixels(),
        .colorByPlot = points.color().empty(),
        .densityRange = densities};
}

void writeStyle(const ParticlesStyle& style, proto::Layer& layer) {
    auto& volume = *layer.mutable_particles()->mutable_volume();
    for (const auto& knot : style.curveByPlot ? std::vector<Curve::Knot>() : style.volumeOpacity.knots()) {
        auto& added = *volume.add_curve();
        added.set_density(knot.x);
        added.set_opacity(knot.y);
    }
    volume.set_color_map(std::string(style.colorMap.name()));
    if (style.densityRange) {
        volume.add_density_range(style.densityRange->low);
        volume.add_density_range(style.densityRange->high);
    }
    auto& points = *layer.mutable_particles()->mutable_points();
    points.set_linked(style.curveByPlot || isLinked(style));
    for (const auto& knot : points.linked() ? std::vector<Curve::Knot>() : style.pointFraction.knots()) {
        auto& added = *points.add_curve();
        added.set_density(knot.x);
        added.set_fraction(knot.y);
    }
    if (!style.opacityByPlot) points.set_opacity(style.pointOpacity);
    if (!style.sizeByPlot) points.set_size_pixels(style.pointSize);
    if (!style.colorByPlot) writeColor(style.pointColor, points.mutable_color());
}

void visitFields(ParticlesStyle& style, const ParticlesStyle& other, FieldVisitor& visitor) {
    visitCurve(visitor, style.volumeOpacity, other.volumeOpacity);
    // Linked to what lies between the volumes they would jump where one of these is nowhere opaque.
    visitCurve(visitor, style.pointFraction, other.pointFraction);
    visitor.word(style.colorMap == other.colorMap);
    visitor.word(style.densityRange == other.densityRange);
    visitor.word(style.curveByPlot == other.curveByPlot && style.opacityByPlot == other.opacityByPlot &&
                 style.sizeByPlot == other.sizeByPlot && style.colorByPlot == other.colorByPlot);
    if (!style.opacityByPlot && !other.opacityByPlot) visitor.number(style.pointOpacity, other.pointOpacity);
    visitor.pixels(style.pointSize, other.pointSize, lengthField("particles.points.sizePixels"));
    visitor.vector(style.pointColor, other.pointColor);
}

}  // namespace mote
