// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/reference/hybrid_field.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "storage/hybrid/normal_table.h"

namespace mote::reference {
namespace {

using render::GridBricks;

/// The place in samples of a grid: sample i lies at (i + 1/2) / size of the box, the outermost ones hold
/// beyond.
glm::dvec3 placeIn(const glm::dvec3& inBox, const glm::uvec3& size) {
    return glm::clamp(inBox * glm::dvec3(size) - 0.5, glm::dvec3(0.0), glm::dvec3(size) - 1.0);
}

double smoothStep(double x) {
    const double held = std::clamp(x, 0.0, 1.0);
    return held * held * (3.0 - 2.0 * held);
}

}  // namespace

Shade shadeOf(const glm::dvec3& n, const Light& light, const Camera& camera, double silhouettes) {
    if (n == glm::dvec3(0.0)) return {std::min(1.0, light.ambient + light.diffuse), 0.0};
    const glm::dmat3 worldToEye(camera.worldToEye());
    const glm::dvec3 l = glm::normalize(light.fixed ? worldToEye * light.direction : light.direction);
    const glm::dvec3 h = glm::normalize(l + glm::dvec3(0.0, 0.0, 1.0));
    const double w = smoothStep((n.z + 0.25) / 0.5);
    const auto power = [](double cosine) { return std::pow(std::max(0.0, cosine), 32.0); };
    const double diffuse = w * std::max(0.0, glm::dot(n, l)) + (1.0 - w) * std::max(0.0, -glm::dot(n, l));
    const double specular = w * power(glm::dot(n, h)) + (1.0 - w) * power(-glm::dot(n, h));
    const double left = 1.0 - silhouettes * std::pow(1.0 - std::abs(n.z), 2.0);
    return {left * std::min(1.0, light.ambient + light.diffuse * diffuse), left * light.specular * specular};
}

Shade shadeOf(std::uint8_t normal, const Light& light, const glm::dmat4& layerToEye, const Camera& camera,
              double silhouettes) {
    static const storage::NormalTable table;
    const glm::dvec3 inLayer(table.direction(normal));
    const bool none = inLayer == glm::dvec3(0.0);
    const glm::dmat3 toEye = glm::inverse(glm::transpose(glm::dmat3(layerToEye)));
    return shadeOf(none ? inLayer : glm::normalize(toEye * inLayer), light, camera, silhouettes);
}

HybridField::HybridField(const render::GridField& step, const Layer& layer, const Camera& camera)
    : step_(step),
      style_(hybridStyleOf(*layer.hybrid())),
      drawn_(render::resolved(style_.representation, step)),
      corrected_(step.bricks != nullptr && drawn_ != HybridRepresentation::volume),
      transfer_(render::transferOf(style_, step)),
      layerToBox_(glm::inverse(step.boxToLayer)) {
    const glm::dmat4 layerToEye = camera.worldToEye() * layer.transform;
    for (std::size_t code = 0; code < shades_.size(); ++code)
        shades_[code] =
            shadeOf(static_cast<std::uint8_t>(code), style_.light, layerToEye, camera, style_.silhouettes);
    if (style_.gradientOpacity > 0.0) findSlopes();
}

/// Of the error grid: of its brick where that is corrected, else of the coarse grid there.
double HybridField::smoothCode(const glm::uvec3& sample) const {
    const GridBricks& bricks = *step_.bricks;
    const glm::uvec3 brick = sample / GridBricks::edge, in = sample % GridBricks::edge;
    const std::int32_t number = bricks.numbers[bricks.index(brick)];
    if (number == GridBricks::none)
        return sampledLow((glm::dvec3(sample) + 0.5) / glm::dvec3(bricks.size)).code;
    return bricks.values[static_cast<std::size_t>(number) * GridBricks::volume +
                         (std::size_t{in.z} * 9 + in.y) * 9 + in.x];
}

/// `perBox`: how much codes change over the box's edges.
double HybridField::slopeOf(const glm::dvec3& perBox) const {
    if (!(deviation_ > 0.0)) return 0.0;
    const glm::dvec3 inLayer = glm::transpose(glm::dmat3(layerToBox_)) * perBox;
    const double within = step_.longestEdge() / 64.0;
    return std::round(255.0 * std::clamp(glm::length(inLayer) * within / deviation_, 0.0, 1.0)) / 255.0;
}

void HybridField::findSlopes() {
    const auto& low = step_.coarse;
    const double count = static_cast<double>(low.size.x) * low.size.y * low.size.z;
    double mean = 0.0, square = 0.0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) mean += low.values[i] / count;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
        square += (low.values[i] - mean) * (low.values[i] - mean) / count;
    deviation_ = std::sqrt(square);
    const auto slopeAt = [&](const glm::uvec3& at, const glm::uvec3& size, const auto& code) {
        glm::dvec3 perBox(0.0);
        for (int axis = 0; axis < 3; ++axis) {
            glm::uvec3 before = at, behind = at;
            if (at[axis] > 0) --before[axis];
            if (at[axis] + 1 < size[axis]) ++behind[axis];
            perBox[axis] = (code(behind) - code(before)) * size[axis] / 2.0;
        }
        return slopeOf(perBox);
    };
    const auto coarseCode = [&](const glm::uvec3& at) {
        return static_cast<double>(low.values[low.index(at)]);
    };
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        const glm::uvec3 at(i % low.size.x, i / low.size.x % low.size.y, i / low.size.x / low.size.y);
        coarseSlopes_.push_back(slopeAt(at, low.size, coarseCode));
    }
    if (!corrected_) return;
    const GridBricks& bricks = *step_.bricks;
    brickSlopes_.resize(bricks.values.size());
    for (std::size_t brick = 0; brick < bricks.numbers.size(); ++brick) {
        if (bricks.numbers[brick] == GridBricks::none) continue;
        const glm::uvec3 first =
            GridBricks::edge * glm::uvec3(brick % bricks.count.x, brick / bricks.count.x % bricks.count.y,
                                          brick / bricks.count.x / bricks.count.y);
        for (unsigned i = 0; i < 729; ++i) {
            const glm::uvec3 at = glm::min(first + glm::uvec3(i % 9, i / 9 % 9, i / 81), bricks.size - 1U);
            brickSlopes_[static_cast<std::size_t>(bricks.numbers[brick]) * 729 + i] =
                slopeAt(at, bricks.size, [&](const glm::uvec3& place) { return smoothCode(place); });
        }
    }
}

/// Between the samples around a place; `last`: the greatest index on each axis. `weightOf`: a sample's, by
/// the share of the way to it from the one before.
template <class Index, class Weight>
HybridField::Sampled HybridField::interpolated(const std::uint16_t* values, const std::uint8_t* normals,
                                               const double* slopes, const glm::dvec3& place,
                                               const glm::uvec3& last, const Index& index,
                                               const Weight& weightOf) const {
    const glm::uvec3 below(place);
    const glm::dvec3 way = place - glm::dvec3(below);
    const glm::dvec3 share(weightOf(way.x), weightOf(way.y), weightOf(way.z));
    Sampled sum;
    for (unsigned corner = 0; corner < 8; ++corner) {
        const glm::uvec3 ahead(corner & 1U, corner >> 1 & 1U, corner >> 2);
        double weight = 1.0;
        for (int axis = 0; axis < 3; ++axis) weight *= ahead[axis] != 0 ? share[axis] : 1.0 - share[axis];
        const std::size_t at = index(glm::min(below + ahead, last));
        sum.code += weight * values[at];
        sum.shade.diffuse += weight * shades_[normals[at]].diffuse;
        sum.shade.specular += weight * shades_[normals[at]].specular;
        if (slopes != nullptr) sum.slope += weight * slopes[at];
    }
    return sum;
}

HybridField::Sampled HybridField::sampledLow(const glm::dvec3& inBox) const {
    const auto& low = step_.coarse;
    return interpolated(
        low.values.data(), low.normals.data(), coarseSlopes_.empty() ? nullptr : coarseSlopes_.data(),
        placeIn(inBox, low.size), low.size - 1U, [&](const glm::uvec3& at) { return low.index(at); },
        [](double share) { return share; });
}

HybridField::Sampled HybridField::sampledBrick(std::int32_t number, const glm::dvec3& inBrick) const {
    const GridBricks& bricks = *step_.bricks;
    const std::size_t begin = static_cast<std::size_t>(number) * GridBricks::volume;
    const bool points = drawn_ == HybridRepresentation::points;
    return interpolated(
        bricks.values.data() + begin, bricks.normals.data() + begin,
        brickSlopes_.empty() ? nullptr : brickSlopes_.data() + begin, inBrick, glm::uvec3(GridBricks::edge),
        [](const glm::uvec3& at) {
            return (std::size_t{at.z} * GridBricks::samples + at.y) * GridBricks::samples + at.x;
        },
        [&](double share) {
            if (points && style_.pointShape == PointShape::disc)
                return std::clamp(2.0 * share - 0.5, 0.0, 1.0);
            if (points && style_.pointShape == PointShape::square)
                return std::clamp(8.0 * share - 3.5, 0.0, 1.0);
            return share;
        });
}

HybridField::Sampled HybridField::sampled(const glm::dvec3& inLayer) const {
    const glm::dvec3 inBox(layerToBox_ * glm::dvec4(inLayer, 1.0));
    if (!corrected_) return sampledLow(inBox);
    const GridBricks& bricks = *step_.bricks;
    const glm::dvec3 place = placeIn(inBox, bricks.size);
    const glm::uvec3 brick = glm::uvec3(place) / GridBricks::edge;
    const std::int32_t number = bricks.numbers[bricks.index(brick)];
    if (number == GridBricks::none) return sampledLow(inBox);
    const Sampled whole = sampledBrick(number, place - glm::dvec3(brick * GridBricks::edge));
    if (drawn_ != HybridRepresentation::points || style_.pointOpacity == 1.0) return whole;
    const Sampled low = sampledLow(inBox);
    const double share = style_.pointOpacity;
    return {std::lerp(low.code, whole.code, share),
            {std::lerp(low.shade.diffuse, whole.shade.diffuse, share),
             std::lerp(low.shade.specular, whole.shade.specular, share)},
            std::lerp(low.slope, whole.slope, share)};
}

double HybridField::value(const glm::dvec3& inLayer) const {
    return step_.valueOf(sampled(inLayer).code);
}

glm::dvec3 HybridField::falling(const glm::dvec3& inLayer) const {
    const glm::dvec3 inBox(layerToBox_ * glm::dvec4(inLayer, 1.0));
    glm::dvec3 size(step_.coarse.size);
    if (corrected_) {
        const GridBricks& bricks = *step_.bricks;
        const glm::uvec3 brick = glm::uvec3(placeIn(inBox, bricks.size)) / GridBricks::edge;
        if (bricks.numbers[bricks.index(brick)] != GridBricks::none) size = glm::dvec3(bricks.size);
    }
    glm::dvec3 slope(0.0);
    for (int axis = 0; axis < 3; ++axis) {
        const glm::dvec3 off = glm::dvec3(step_.boxToLayer[axis]) / size[axis];
        slope[axis] = (sampled(inLayer + off).code - sampled(inLayer - off).code) * size[axis];
    }
    return -(glm::transpose(glm::dmat3(layerToBox_)) * slope);
}

VolumeMatter HybridField::at(const glm::dvec3& inLayer) const {
    const Sampled here = sampled(inLayer);
    const double v = step_.valueOf(here.code);
    const double share = std::lerp(1.0, here.slope, style_.gradientOpacity);
    return {share * transfer_.extinction(v), transfer_.color(v) * here.shade.diffuse + here.shade.specular};
}

std::vector<HalfSpace> HybridField::within() const {
    std::vector<HalfSpace> sides;
    const glm::dmat4 rows = glm::transpose(layerToBox_);
    for (int axis = 0; axis < 3; ++axis) {
        const glm::dvec3 normal(rows[axis]);
        sides.push_back({normal, -rows[axis].w});
        sides.push_back({-normal, rows[axis].w - 1.0});
    }
    return sides;
}

double HybridField::cellEdge() const {
    const glm::dvec3 size(corrected_ ? step_.bricks->size : step_.coarse.size);
    double least = step_.longestEdge();
    for (int axis = 0; axis < 3; ++axis)
        least = std::min(least, glm::length(glm::dvec3(step_.boxToLayer[axis])) / size[axis]);
    return least;
}

}  // namespace mote::reference
