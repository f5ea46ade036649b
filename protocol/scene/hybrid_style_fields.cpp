// SPDX-License-Identifier: GPL-3.0-or-later
#include <utility>

#include "protocol/scene/hybrid_style.h"
#include "protocol/scene/mix_curve.h"
#include "protocol/scene/style_kinds.h"

namespace mote {
namespace {

/// The knots from the first of which to the last the colour map goes where nothing else is said.
bool hasSpan(const Curve& curve) {
    return curve.knots().front().x < curve.knots().back().x;
}

/// Whether two curves that say where their colour map begins and ends have such curves between them.
bool canMixSpans(const Curve& from, const Curve& to) {
    if (hasSpan(from) != hasSpan(to)) return false;
    return hasSpan(from) || from.knots().size() == to.knots().size();
}

void visitColorRange(HybridStyle& style, const HybridStyle& other, FieldVisitor& visitor) {
    visitor.word(style.colorRange.has_value() == other.colorRange.has_value());
    if (!style.colorRange || !other.colorRange) return;
    visitor.number(style.colorRange->low, other.colorRange->low);
    visitor.number(style.colorRange->high, other.colorRange->high);
}

void visitTransfer(HybridStyle& style, const HybridStyle& other, FieldVisitor& visitor) {
    visitColorRange(style, other, visitor);
    visitor.word(style.colors.empty() == other.colors.empty());
    visitor.word(style.colorMap == other.colorMap);
    visitor.word(style.opacity.has_value() == other.opacity.has_value());
    if (!style.opacity || !other.opacity) return;
    const ColoredCurve from{*style.opacity, style.colors}, to{*other.opacity, other.colors};
    const bool rangeByKnots = style.colors.empty() && !style.colorRange;
    if (!canMix(from, to) || (rangeByKnots && !canMixSpans(from.curve, to.curve))) {
        visitor.word(from == to);
        return;
    }
    visitor.between([&](double share) {
        auto mixed = mixCurves(from, to, share);
        style.opacity = std::move(mixed.curve);
        style.colors = std::move(mixed.colors);
        // The knots of both together span more than either's: the colours go from the one's range to the
        // other's.
        if (!rangeByKnots || from.curve.knots().size() == to.curve.knots().size()) return;
        const auto &a = from.curve.knots(), &b = to.curve.knots();
        style.colorRange =
            ValueRange{mix(a.front().x, b.front().x, share), mix(a.back().x, b.back().x, share)};
    });
}

void visitClips(HybridStyle& style, const HybridStyle& other, FieldVisitor& visitor) {
    const bool asMany = style.clipPlanes.size() == other.clipPlanes.size();
    visitor.word(asMany && style.clipBox.has_value() == other.clipBox.has_value());
    for (std::size_t i = 0; asMany && i < style.clipPlanes.size(); ++i) {
        auto& plane = style.clipPlanes[i];
        const auto& toPlane = other.clipPlanes[i];
        visitor.between([&, from = plane](double share) {
            plane.normal = mixDirections(from.normal, toPlane.normal, share);
            plane.distance = mix(from.distance, toPlane.distance, share);
        });
    }
    if (!style.clipBox || !other.clipBox) return;
    visitor.vector(style.clipBox->min, other.clipBox->min);
    visitor.vector(style.clipBox->max, other.clipBox->max);
}

}  // namespace

void visitFields(HybridStyle& style, const HybridStyle& other, FieldVisitor& visitor) {
    visitor.word(style.representation == other.representation && style.pointShape == other.pointShape);
    visitTransfer(style, other, visitor);
    visitor.number(style.pointOpacity, other.pointOpacity);
    visitor.light(style.light, other.light);
    visitClips(style, other, visitor);
}

}  // namespace mote
