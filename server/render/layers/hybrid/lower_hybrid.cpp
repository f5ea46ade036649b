// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/hybrid/lower_hybrid.h"

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include "protocol/scene/curve_presets.h"
#include "protocol/scene/light.h"
#include "server/render/plan/field_plan.h"
#include "storage/hybrid/normal_table.h"

namespace mote::render {
namespace {

/// The mean of the terms of n and of -n, weighted by how far n is turned to the eye.
template <class Term>
double twoSided(double towardsEye, double cosine, const Term& term) {
    const double x = std::clamp(2.0 * towardsEye + 0.5, 0.0, 1.0);
    const double front = x * x * (3.0 - 2.0 * x);
    return front * term(std::max(0.0, cosine)) + (1.0 - front) * term(std::max(0.0, -cosine));
}

/// Returns what a light makes of each one-byte normal (docs/PICTURE.md, "Light"). `layerToEye`: takes normals
/// of layer space to eye space; `worldToEye`: a fixed light.
Shades shadesOf(const Light& light, const glm::dmat4& layerToEye, const glm::dmat4& worldToEye) {
    Shades shades;
    static const storage::NormalTable normals;
    // Normals go by the inverse transpose.
    const glm::dmat3 toEye = glm::transpose(glm::inverse(glm::dmat3(layerToEye)));
    const glm::dvec3 towards =
        glm::normalize(light.fixed ? glm::dmat3(worldToEye) * light.direction : light.direction);
    const glm::dvec3 sum = towards + glm::dvec3(0.0, 0.0, 1.0);
    const glm::dvec3 half = glm::length(sum) > 1e-9 ? glm::normalize(sum) : glm::dvec3(0.0);
    const auto held = [](double x) { return static_cast<float>(std::min(x, 1.0)); };
    shades.fill({held(light.ambient + light.diffuse), 0.0F});
    for (int code = 0; code < 256; ++code) {
        const glm::dvec3 normal(normals.direction(static_cast<std::uint8_t>(code)));
        if (!(glm::length(normal) > 0.0)) continue;
        const glm::dvec3 n = glm::normalize(toEye * normal);
        const double diffuse = twoSided(n.z, glm::dot(n, towards), [](double x) { return x; });
        const double specular = twoSided(n.z, glm::dot(n, half), [](double x) { return std::pow(x, 32.0); });
        shades[static_cast<std::size_t>(code)] = {held(light.ambient + light.diffuse * diffuse),
                                                  static_cast<float>(light.specular * specular)};
    }
    return shades;
}

/// The range from the least to the greatest knot; a small range if there is but one.
ValueRange knotsOf(const Curve& curve, const ValueRange& all) {
    const double low = curve.knots().front().x, high = curve.knots().back().x;
    return {low, high > low ? high : low + (all.high - all.low) / 256.0};
}

/// The range with a margin, so that a step at a knot lies inside; of a table's 4095 cells 63 on either side,
/// so that both ends of the range are ends of cells.
ValueRange around(const ValueRange& range) {
    const double margin = (range.high - range.low) / 63.0;
    return {range.low - margin, range.high + margin};
}

/// A half-space of layer space, in the box.
HalfSpace inBox(const HalfSpace& layer, const glm::dmat4& boxToLayer) {
    return {glm::transpose(glm::dmat3(boxToLayer)) * layer.normal,
            layer.distance - glm::dot(layer.normal, glm::dvec3(boxToLayer[3]))};
}

std::vector<HalfSpace> clipsOf(const HybridStyle& style, const glm::dmat4& boxToLayer) {
    std::vector<HalfSpace> clips;
    for (const auto& plane : style.clipPlanes) clips.push_back(inBox(plane, boxToLayer));
    if (!style.clipBox) return clips;
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 normal(0.0);
        normal[axis] = 1.0;
        clips.push_back(inBox({normal, style.clipBox->min[axis]}, boxToLayer));
        clips.push_back(inBox({-normal, -style.clipBox->max[axis]}, boxToLayer));
    }
    return clips;
}

/// Points are corrections that a style weakens and gives a shape.
CorrectedField samplesOf(const HybridStyle& style, const std::shared_ptr<const GridField>& field,
                         const Shades& shades) {
    const auto representation = resolved(style.representation, *field);
    CorrectedField samples{
        .grid = field, .bricks = representation != HybridRepresentation::volume, .shades = shades};
    if (representation == HybridRepresentation::points) {
        samples.correction = style.pointOpacity;
        samples.steepness = style.pointSteepness();
    }
    return samples;
}

}  // namespace

Curve defaultOpacity(const GridField& field) {
    const std::vector<std::uint64_t> histogram(field.histogram.begin(), field.histogram.end());
    const auto knots = presetsOf("", field.range, histogram).front().knots;
    return Curve::create(knots, knots.front().x, knots.back().x).value();
}

HybridRepresentation resolved(HybridRepresentation asked, const GridField& field) {
    return asked == HybridRepresentation::best ? field.parts : asked;
}

TransferFunction transferOf(const HybridStyle& style, const GridField& field) {
    TransferFunction transfer{.opacity = style.opacity ? *style.opacity : defaultOpacity(field),
                              .opacityLength = HybridStyle::opacityShare * field.longestEdge(),
                              .colorMap = style.colorMap,
                              .colors = style.colors};
    transfer.span = knotsOf(transfer.opacity, field.range);
    transfer.colorRange = style.colorRange ? *style.colorRange : transfer.span;
    if (transfer.colors.empty()) {
        transfer.span = {std::min(transfer.span.low, transfer.colorRange.low),
                         std::max(transfer.span.high, transfer.colorRange.high)};
    }
    transfer.span = around(transfer.span);
    return transfer;
}

void lowerHybrid(const Layer& layer, std::size_t index, const HybridStyle& style,
                 const std::shared_ptr<const GridField>& field, Lowering& out) {
    const glm::dmat4 worldToEye = out.plan.camera.worldToEye();
    const glm::dmat4 layerToEye = worldToEye * layer.transform;
    const glm::dmat4 boxToEye = layerToEye * field->boxToLayer;
    out.addBox(Bounds{glm::dvec3(0.0), glm::dvec3(1.0)}.transformed(boxToEye));
    out.plan.fields.push_back(
        {.layer = index,
         .boxToEye = boxToEye,
         .boxToLayer = glm::dmat3(field->boxToLayer),
         .transfer = thinned(transferOf(style, *field), layer.opacity),
         .clips = clipsOf(style, field->boxToLayer),
         .samples = samplesOf(style, field, shadesOf(style.light, layerToEye, worldToEye))});
}

}  // namespace mote::render
