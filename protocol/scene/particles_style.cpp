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

Status checkDensityRange(const proto::VolumeStyle& message) {
    const auto& range = message.density_range();
    if (range.empty()) return success();
    const bool valid = range.size() == 2 && std::isfinite(range[1]) && range[0] > 0.0 && range[0] < range[1];
    return valid ? success()
                 : invalid("volume.densityRange", "there must be two densities above 0, ascending");
}

Curve volumeCurve(const proto::VolumeStyle& message) {
    std::vector<Curve::Knot> knots;
    for (const auto& knot : message.curve()) knots.push_back({knot.density(), knot.opacity()});
    if (knots.empty()) knots = defaultVolumeKnots();
    return Curve::create(std::move(knots)).value();
}

/// Errors: of a curve.
Result<Curve> ownPointCurve(const proto::PointsStyle& message) {
    std::vector<Curve::Knot> knots;
    for (const auto& knot : message.curve()) knots.push_back({knot.density(), knot.fraction()});
    return Curve::create(std::move(knots));
}

Curve pointCurve(const proto::ParticlesStyle& style) {
    if (style.points().linked()) return linkedFraction(volumeCurve(style.volume()));
    return ownPointCurve(style.points()).value();
}

Status checkPointCurve(const proto::PointsStyle& message) {
    if (!message.linked()) {
        MOTE_RETURN_IF_ERROR(ownPointCurve(message), "points.curve");
        return success();
    }
    if (message.curve().empty()) return success();
    return invalid("points.curve",
                   "a point curve needs \"linked\": false; linked points follow the volume's curve");
}

/// Says the curve of a volume that is not left to the plot.
void sayVolumeCurve(proto::ParticlesStyle& style) {
    auto& volume = *style.mutable_volume();
    if (style.points().linked() || !volume.curve().empty()) return;
    for (const auto& knot : defaultVolumeKnots()) {
        auto& added = *volume.add_curve();
        added.set_density(knot.x);
        added.set_opacity(knot.y);
    }
}

/// Points have the same curve, as their own.
void unlink(proto::ParticlesStyle& style) {
    const Curve fraction = pointCurve(style);
    auto& points = *style.mutable_points();
    points.set_linked(false);
    points.clear_curve();
    for (const auto& knot : fraction.knots()) {
        auto& added = *points.add_curve();
        added.set_density(knot.x);
        added.set_fraction(knot.y);
    }
}

/// Points whose own curve gives way to the volume are linked.
void linkWhereAlike(proto::ParticlesStyle& style) {
    auto& points = *style.mutable_points();
    if (points.linked() || pointCurve(style) != linkedFraction(volumeCurve(style.volume()))) return;
    points.set_linked(true);
    points.clear_curve();
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

Result<proto::ParticlesStyle> parseParticlesStyle(proto::ParticlesStyle message) {
    MOTE_ASSIGN_OR_RETURN(auto style, resolved(std::move(message)));
    MOTE_RETURN_IF_ERROR(checkPointCurve(style.points()));
    MOTE_RETURN_IF_ERROR(checkDensityRange(style.volume()));
    auto& points = *style.mutable_points();
    if (points.has_opacity()) points.set_opacity(std::min(points.opacity(), ParticlesStyle::opacityLimit));
    sayVolumeCurve(style);
    linkWhereAlike(style);
    return style;
}

ParticlesStyle particlesStyleOf(const proto::ParticlesStyle& message, std::uint32_t lines) {
    const auto& volume = message.volume();
    const auto& points = message.points();
    ParticlesStyle style{
        .volumeOpacity = volumeCurve(volume),
        .colorMap = ColorMap::find(volume.color_map()).value(),
        .pointFraction = pointCurve(message),
        .pointOpacity = points.has_opacity() ? points.opacity() : unknownOpacity,
        .pointSize = lengthField("particles.points.sizePixels")
                         .inPixels(lengthOf(points, points.kSizePixelsFieldNumber), lines, 1.0),
        .pointColor = colorOf(points, points.kColorFieldNumber).value_or(srgbToLinear(usualColor)),
        .curveByPlot = volume.curve().empty(),
        .opacityByPlot = !points.has_opacity(),
        .sizeByPlot = !points.has_size_pixels(),
        .colorByPlot = points.color().empty()};
    if (!volume.density_range().empty())
        style.densityRange = ValueRange{volume.density_range(0), volume.density_range(1)};
    return style;
}

/// Two ranges of densities have nothing in between, nor has a size with what a plot makes of it. Points that
/// are linked go from the one fraction to the other: linked to what lies between the volumes they would jump
/// where one of these is nowhere opaque.
void visitFields(proto::ParticlesStyle& style, const proto::ParticlesStyle& other, FieldVisitor& visitor) {
    auto to = other;
    const auto& range = style.volume().density_range();
    auto& densities = *to.mutable_volume()->mutable_density_range();
    visitor.word(std::ranges::equal(range, densities));
    densities = range;
    const bool sized = style.points().has_size_pixels();
    visitor.word(sized == other.points().has_size_pixels());
    if (sized != other.points().has_size_pixels())
        to.mutable_points()->set_size_pixels(style.points().size_pixels());
    const bool bothCurves = !style.volume().curve().empty() && !to.volume().curve().empty();
    for (auto* const one : {&style, &to}) {
        if (bothCurves) unlink(*one);
    }
    visitFields(static_cast<google::protobuf::Message&>(style), to, visitor);
    if (bothCurves) linkWhereAlike(style);
    if (!sized) style.mutable_points()->clear_size_pixels();
}

}  // namespace mote
