// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/frame_block.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>
#include <glm/packing.hpp>

#include "protocol/scene/srgb.h"
#include "server/render/screen_map.h"

namespace mote::render {
namespace {

constexpr double originUnits = 2147483648.0;  // of the box's edge: 2^31

double slabThickness(const FramePlan& plan) {
    return (plan.farDepth - plan.nearDepth) / plan.slabs;
}

/// The ray through (x, y) of the picture's window at slab s, in the box: entry + s * advance, both linear in
/// (1, x, y).
void setRays(LayerBlock& block, const FramePlan& plan, const LayerPlan& layer) {
    const glm::dmat4 eyeToBox = glm::inverse(layer.layerToEye * boxToLayer());
    const glm::dvec3 right(eyeToBox[0]), up(eyeToBox[1]), away(-eyeToBox[2]), eye(eyeToBox[3]);
    const double thickness = slabThickness(plan);
    const bool perspective = plan.camera.perspective();
    const double spread = perspective ? plan.nearDepth : 1.0;
    block.entry = {glm::vec4(eye + plan.nearDepth * away, 0.0), glm::vec4(spread * right, 0.0),
                   glm::vec4(spread * up, 0.0)};
    const double turn = perspective ? thickness : 0.0;
    block.advance = {glm::vec4(thickness * away, 0.0), glm::vec4(turn * right, 0.0),
                     glm::vec4(turn * up, 0.0)};
}

/// Sums of weights stay below 2^32 whatever pixel the points meet in, with half a unit of rounding each.
std::uint32_t weightUnit(std::uint64_t points) {
    constexpr std::uint64_t most = 1U << 16;
    return static_cast<std::uint32_t>(
        std::clamp<std::uint64_t>(0xffffffffULL / std::max<std::uint64_t>(points, 1), 1, most));
}

}  // namespace

glm::uvec4 blankPixel(const glm::dvec3& background, PixelFormat format) {
    if (format == PixelFormat::linearHalf) {
        return {glm::packHalf2x16(glm::vec2(background.x, background.y)),
                glm::packHalf2x16(glm::vec2(background.z, 1.0)), 0, 0};
    }
    const glm::dvec3 encoded = glm::clamp(linearToSrgb(background), 0.0, 1.0);
    return {glm::packUnorm4x8(glm::vec4(encoded, 1.0)), 0, 0, 0};
}

PointNumbers pointNumbers(const FramePlan& plan, const LayerPlan& layer) {
    const double size = layer.style.pointSize;
    const double opacity = layer.style.pointOpacity * std::min(size * size, 1.0);
    const glm::dmat4 toScreen = boxToScreen(plan, layer);
    // Relative to the camera's target, for a camera that comes close to something looks at it.
    const glm::dvec3 target(glm::inverse(layer.layerToEye * boxToLayer()) *
                            (plan.camera.worldToEye() * glm::dvec4(plan.camera.target, 1.0)));
    const glm::uvec3 origin(glm::clamp(target, 0.0, 1.0) * (originUnits - 1.0));
    const glm::dmat4 toBox = glm::scale(glm::translate(glm::dmat4(1.0), glm::dvec3(origin) / originUnits),
                                        glm::dvec3(1.0 / originUnits));
    return {.toScreen = glm::mat4(toScreen * toBox),
            .origin = origin,
            // A little less, for rounding at the very border of the box.
            .nearest = plan.camera.perspective() ? static_cast<float>(plan.nearDepth * (1.0 - 1e-5)) : 0.0F,
            .discs = size > 1.0,
            .radius = static_cast<float>(0.5 * size + 0.5),
            .opacity = static_cast<float>(opacity),
            .tau = static_cast<float>(-std::log1p(-opacity)),
            .unit = weightUnit(layer.pointsDrawn)};
}

FrameBlock frameBlock(const FramePlan& plan, PixelFormat format, std::uint32_t firstRow, std::uint32_t rows,
                      const std::array<std::uint32_t, 8>& volumeSizes) {
    const std::uint32_t tilesAcross = (plan.width + 7) / 8;
    const double half = plan.camera.halfHeight();
    FrameBlock block{};
    block.picture = glm::ivec4(plan.width, plan.height, tilesAcross, firstRow);
    const std::uint32_t pixelRows = std::min(rows * 8, plan.height - firstRow * 8);
    block.band = glm::ivec4(tilesAcross * rows, plan.slabs, format == PixelFormat::linearHalf, pixelRows);
    block.window = glm::vec4(half * plan.width / plan.height, half, plan.samplesPerCell, 0.0);
    block.background = glm::vec4(plan.background, 1.0);
    block.blank = blankPixel(plan.background, format);
    for (std::size_t i = 0; i < plan.layers.size(); ++i) {
        const LayerPlan& layer = plan.layers[i];
        const PointNumbers numbers = pointNumbers(plan, layer);
        LayerBlock& result = block.layers[i];
        result.boxToScreen = glm::mat4(boxToScreen(plan, layer));
        setRays(result, plan, layer);
        result.point = glm::vec4(layer.style.pointColor, numbers.tau);
        result.scale = glm::vec4(1.0 / numbers.unit, volumeSizes[i], 0.0, 0.0);
    }
    return block;
}

}  // namespace mote::render
