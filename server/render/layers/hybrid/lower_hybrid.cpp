// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/hybrid/lower_hybrid.h"

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "protocol/scene/curve_presets.h"
#include "protocol/scene/srgb.h"
#include "server/render/layers/hybrid/field_light.h"
#include "server/render/layers/hybrid/field_sight.h"
#include "server/render/plan/field_plan.h"
#include "storage/hybrid/normal_table.h"

namespace mote::render {
namespace {

/// Returns what a light makes of each one-byte normal. `layerToEye`: takes normals of layer space to eye
/// space.
Shades shadesOf(const FieldLight& light, const glm::dmat4& layerToEye) {
    Shades shades;
    static const storage::NormalTable normals;
    // Normals go by the inverse transpose.
    const glm::dmat3 toEye = glm::transpose(glm::inverse(glm::dmat3(layerToEye)));
    shades.fill(light.flat());
    for (int code = 0; code < 256; ++code) {
        const glm::dvec3 normal(normals.direction(static_cast<std::uint8_t>(code)));
        if (glm::length(normal) > 0.0)
            shades[static_cast<std::size_t>(code)] = light.of(glm::normalize(toEye * normal));
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

std::vector<std::uint64_t> histogramOf(const GridField& field) {
    return {field.histogram.begin(), field.histogram.end()};
}

/// The curve, and colours, that follow the values.
CurvePreset defaultPreset(const GridField& field) {
    return presetsOf(field.unit, field.range, histogramOf(field)).front();
}

/// Values that have colours of their own where a view does not say the range: the curve's, and, of greatest
/// values, which may all lie beyond it, up to the highest.
ValueRange coloredValues(const HybridStyle& style, const GridField& field, ValueRange knots) {
    if (style.shows == HybridShows::maximum)
        knots.high = std::max(knots.high, highestShown(histogramOf(field), field.range));
    return knots;
}

/// Those of the default curve, if it is drawn; or of the colour map what can be read.
void takeDefaultColors(const HybridStyle& style, const GridField& field, TransferFunction& transfer) {
    if (!style.opacity) {
        for (const auto& color : defaultPreset(field).colors)
            transfer.colors.push_back(srgbToLinear(glm::dvec3(color[0], color[1], color[2])));
    }
    if (!style.colorRange) transfer.colorRange = readableColors(transfer.colorRange);
}

/// Points are corrections that a style weakens and gives a shape.
CorrectedField samplesOf(const HybridStyle& style, const std::shared_ptr<const GridField>& field,
                         const Shades& shades) {
    const auto representation = resolved(style.representation, *field);
    CorrectedField samples{.grid = field,
                           .bricks = representation != HybridRepresentation::volume,
                           .gradient = style.gradientOpacity,
                           .shades = shades};
    if (representation == HybridRepresentation::points) {
        samples.correction = style.pointOpacity;
        samples.steepness = style.pointSteepness();
    }
    return samples;
}

}  // namespace

Curve defaultOpacity(const GridField& field) {
    const auto knots = defaultPreset(field).knots;
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
    transfer.colorRange = style.colorRange ? *style.colorRange : coloredValues(style, field, transfer.span);
    if (!style.ownColors) takeDefaultColors(style, field, transfer);
    if (transfer.colors.empty()) {
        transfer.span = {std::min(transfer.span.low, transfer.colorRange.low),
                         std::max(transfer.span.high, transfer.colorRange.high)};
    }
    transfer.span = around(transfer.span);
    return transfer;
}

namespace {

/// Tells a camera of samples that are seen: in each row the first and the last count.
class SeenSamples {
  public:
    SeenSamples(const GridField& field, const TransferFunction& transfer, CameraFit& fit)
        : boxToLayer_(field.boxToLayer), fit_(fit), seen_(65536) {
        constexpr double least = 0.02;  // of the greatest opacity
        const double from = least * transfer.opacity.maximum();
        for (std::size_t code = 0; code < seen_.size(); ++code) {
            const double opacity = transfer.opacity(field.valueOf(static_cast<double>(code)));
            seen_[code] = opacity > 0.0 && opacity >= from ? 1 : 0;
        }
    }

    /// `count` samples of a row of cells of the box, from the cell `first` of a grid of `size`.
    void addRow(const std::uint16_t* codes, std::uint32_t count, const glm::uvec3& first,
                const glm::uvec3& size) const {
        const auto addFirst = [&](auto from, auto to, int step) {
            for (auto i = from; i != to; i += step) {
                const glm::uvec3 cell(first.x + static_cast<std::uint32_t>(i), first.y, first.z);
                if (seen_[codes[i]] != 0 && add(cell, size)) return;
            }
        };
        addFirst(std::int64_t{0}, std::int64_t{count}, 1);
        addFirst(std::int64_t{count} - 1, std::int64_t{-1}, -1);
    }
    /// Whether cells may count, from one to another.
    bool mayCount(const glm::uvec3& first, const glm::uvec3& end, const glm::uvec3& size) const {
        const Bounds box{glm::dvec3(first) / glm::dvec3(size), glm::dvec3(end) / glm::dvec3(size)};
        return fit_.reach(box.transformed(boxToLayer_)) > 0.0;
    }

  private:
    bool add(const glm::uvec3& cell, const glm::uvec3& size) const {
        if (cell.x >= size.x || cell.y >= size.y || cell.z >= size.z) return false;
        const glm::dvec3 inBox = (glm::dvec3(cell) + 0.5) / glm::dvec3(size);
        const glm::dvec3 place(boxToLayer_ * glm::dvec4(inBox, 1.0));
        if (!fit_.takes(place)) return false;
        // What is seen of it reaches as far as halfway to its neighbours.
        const Bounds cellInBox{glm::dvec3(cell) / glm::dvec3(size), glm::dvec3(cell + 1U) / glm::dvec3(size)};
        for (const auto& corner : cellInBox.corners())
            fit_.add(glm::dvec3(boxToLayer_ * glm::dvec4(corner, 1.0)));
        return true;
    }

    const glm::dmat4 boxToLayer_;
    CameraFit& fit_;
    std::vector<std::uint8_t> seen_;  // by code
};

void addSeenBricks(const GridBricks& bricks, const SeenSamples& seen) {
    for (std::size_t i = 0; i < bricks.numbers.size(); ++i) {
        if (bricks.numbers[i] == GridBricks::none) continue;
        const auto [x, y, z] = std::tuple(i % bricks.count.x, i / bricks.count.x % bricks.count.y,
                                          i / bricks.count.x / bricks.count.y);
        const glm::uvec3 first = GridBricks::edge * glm::uvec3(x, y, z);
        if (!seen.mayCount(first, first + GridBricks::samples, bricks.size)) continue;
        const auto* row = &bricks.values[static_cast<std::size_t>(bricks.numbers[i]) * GridBricks::volume];
        for (std::uint32_t k = 0; k < GridBricks::samples; ++k) {
            for (std::uint32_t j = 0; j < GridBricks::samples; ++j, row += GridBricks::samples)
                seen.addRow(row, GridBricks::samples, first + glm::uvec3(0, j, k), bricks.size);
        }
    }
}

}  // namespace

void addShown(const GridField& field, const TransferFunction& transfer, HybridRepresentation drawn,
              CameraFit& fit) {
    const SeenSamples seen(field, transfer, fit);
    const auto& size = field.coarse.size;
    for (std::uint32_t z = 0; z < size.z; ++z) {
        for (std::uint32_t y = 0; y < size.y; ++y)
            seen.addRow(&field.coarse.values[field.coarse.index({0, y, z})], size.x, {0, y, z}, size);
    }
    if (field.bricks != nullptr && drawn != HybridRepresentation::volume) addSeenBricks(*field.bricks, seen);
}

void lowerHybrid(const Layer& layer, std::size_t index, const HybridStyle& style,
                 const std::shared_ptr<const GridField>& field, Lowering& out) {
    if (style.shows != HybridShows::matter) {
        out.last.emplace_back([&layer, style, field, &out] { lowerSight(layer, style, field, out); });
        return;
    }
    const glm::dmat4 worldToEye = out.plan.camera.worldToEye();
    const glm::dmat4 layerToEye = worldToEye * layer.transform;
    const glm::dmat4 boxToEye = layerToEye * field->boxToLayer;
    out.addBox(Bounds{glm::dvec3(0.0), glm::dvec3(1.0)}.transformed(boxToEye));
    out.plan.fields.push_back(
        {.layer = index,
         .boxToEye = boxToEye,
         .boxToLayer = glm::dmat3(field->boxToLayer),
         .transfer = thinned(transferOf(style, *field), layer.opacity),
         .clips = inSpace(layer.clips(), field->boxToLayer),
         .samples =
             samplesOf(style, field, shadesOf({style.light, worldToEye, style.silhouettes}, layerToEye))});
}

}  // namespace mote::render
