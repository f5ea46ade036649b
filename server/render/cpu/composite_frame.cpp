// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/composite_frame.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "server/render/blank_picture.h"
#include "server/render/cpu/packed_volume.h"
#include "server/render/plan/screen_map.h"

namespace mote::render {
namespace {

/// Around the box's projection; all there is where that is unbounded, since the box reaches behind the eye.
PixelRange screenOf(const glm::dmat4& toScreen) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    constexpr double margin = 1.0;  // for rounding
    PixelRange range{glm::dvec2(infinite), glm::dvec2(-infinite)};
    for (unsigned i = 0; i < 8; ++i) {
        const glm::dvec4 corner = toScreen * glm::dvec4(i & 1U, i >> 1 & 1U, i >> 2 & 1U, 1.0);
        if (!(corner.w > 0.0)) return {glm::dvec2(-infinite), glm::dvec2(infinite)};
        const glm::dvec2 at(corner.x / corner.w, corner.y / corner.w);
        range = {glm::min(range.low, at - margin), glm::max(range.high, at + margin)};
    }
    return range;
}

double meanSlab(const FramePlan& plan) {
    return (plan.farDepth - plan.nearDepth) / plan.slabs;
}

RayMap raysOf(const FramePlan& plan, const glm::dmat4& boxToEye) {
    return {plan, boxToEye, plan.nearDepth, meanSlab(plan)};
}

std::vector<FrameSection> sectionsOf(const FramePlan& plan) {
    std::vector<FrameSection> sections;
    const double mean = meanSlab(plan);
    for (const auto& section : plan.sections) {
        // One section is the whole, to the last bit.
        const bool only = plan.sections.size() == 1;
        sections.push_back({section.firstSlab, section.slabs, (section.nearDepth - plan.nearDepth) / mean,
                            only ? 1.0 : section.thickness() / mean});
    }
    return sections;
}

std::array<std::uint32_t, 256> packedShades(const HybridLight& light) {
    std::array<std::uint32_t, 256> packed{};
    const auto bits = [](float x) {
        return static_cast<std::uint32_t>(std::lround(x * HybridLayer::fullShade));
    };
    for (std::size_t code = 0; code < packed.size(); ++code) {
        const auto& shade = light.shades()[code];
        packed[code] = bits(shade.diffuse) | bits(shade.specular) << 16;
    }
    return packed;
}

/// The edge of the cube with the volume of a cell, in pixels of the picture, in the middle of the box; where
/// the eye is nearer than half the box's edge, at that distance.
double pixelsPerCell(const FramePlan& plan, const HybridPlan& hybrid, const glm::dvec3& cells) {
    const double volume = std::abs(glm::determinant(glm::dmat3(hybrid.boxToEye)));
    const double edge = std::cbrt(volume / (cells.x * cells.y * cells.z));
    const double depth = -(hybrid.boxToEye * glm::dvec4(0.5, 0.5, 0.5, 1.0)).z;
    const double away = plan.camera.perspective() ? std::max(depth, 0.5 * std::cbrt(volume)) : 1.0;
    return edge / away * plan.height / (2.0 * plan.camera.halfHeight());
}

/// The stretches of a hybrid volume to a cell's edge. At rest they bound what is leapt over and what is mixed
/// in one step. In motion they are the distances of samples: no shorter than a pixel is wide, up to four
/// cells, as what is finer no pixel shows either.
double hybridSamples(const FramePlan& plan, const HybridPlan& hybrid, const glm::dvec3& cells) {
    constexpr double least = 0.25;
    const double most = hybrid.corrected() ? 1.25 : 6.0;
    if (plan.exact) return most;
    return std::clamp(plan.samplesPerCell * std::min(1.0, pixelsPerCell(plan, hybrid, cells)), least, most);
}

HybridLayer hybridLayer(const FramePlan& plan, const HybridPlan& hybrid, const VisibleHybrid& visible) {
    const HybridStep& step = *hybrid.step;
    const HybridBricks* const bricks = hybrid.corrected() ? step.bricks.get() : nullptr;
    const glm::dvec3 low(step.low.size), cells(bricks != nullptr ? bricks->size : step.low.size);
    const glm::dvec3 ratio = cells / low;
    const VolumeTable& table = *visible.table;
    const double perValue = VolumeTable::cells / (table.high() - table.low());
    return {
        .rays = raysOf(plan, hybrid.boxToEye),
        .screen = screenOf(boxToScreen(plan, hybrid.boxToEye)),
        .space = {.cells = cells,
                  .shift = -0.5,
                  .samples = hybridSamples(plan, hybrid, cells),
                  .toLayer = glm::dmat3(step.boxToLayer),
                  .clips = hybrid.clips},
        .blocks = visible.blocks,
        .table = visible.table,
        .tableScale = static_cast<float>((step.range.high - step.range.low) / 65535.0 * perValue),
        .tableShift = static_cast<float>(1.0 + (step.range.low - table.low()) * perValue),
        .low = &step.low,
        .bricks = bricks,
        .correction = static_cast<float>(hybrid.correction()),
        .steepness = static_cast<float>(hybrid.steepness()),
        // Twice as many to a cell of the low volume as to one of a brick; whole, so that both meet.
        .coarse = std::max(1.0F, std::floor(static_cast<float>(0.5 * std::min({ratio.x, ratio.y, ratio.z})))),
        .lowScale = glm::vec3(low / cells),
        .lowShift = glm::vec3(0.5 * low / cells - 0.5),
        .shades = packedShades(hybrid.light)};
}

}  // namespace

CompositeFrame::CompositeFrame(const FramePlan& plan, PixelFormat chosen,
                               const std::vector<VisibleVolume>& volumes,
                               const std::vector<VisibleHybrid>& visibleHybrids)
    : width(plan.width),
      height(plan.height),
      slabs(plan.slabs),
      sections(sectionsOf(plan)),
      samplesPerCell(static_cast<float>(std::clamp(plan.samplesPerCell, 0.25, 64.0))),
      cellByCell(plan.samplesPerCell >= 2.0),
      window(plan.camera.halfHeight() * plan.width / plan.height, plan.camera.halfHeight()),
      background(plan.background),
      format(chosen),
      blank(blankPixel(plan.background, chosen)) {
    for (std::size_t i = 0; i < plan.layers.size(); ++i) {
        const LayerPlan& layer = plan.layers[i];
        const double size = std::min(layer.style.pointSize, 1.0);
        layers.push_back(
            {.rays = raysOf(plan, layer.layerToEye * boxToLayer()),
             .screen = screenOf(boxToScreen(plan, layer)),
             .visible = volumes[i],
             .pointColor = glm::vec3(layer.style.pointColor),
             .pointTau = static_cast<float>(-std::log1p(-layer.style.pointOpacity * size * size))});
    }
    for (std::size_t i = 0; i < plan.hybrids.size(); ++i)
        hybrids.push_back(hybridLayer(plan, plan.hybrids[i], visibleHybrids[i]));
}

}  // namespace mote::render
