// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/frame_block.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

#include "server/render/blank_picture.h"
#include "server/render/ray_map.h"
#include "server/render/screen_map.h"

namespace mote::render {
namespace {

constexpr double originUnits = 2147483648.0;  // of the box's edge: 2^31

void setRays(LayerBlock& block, const RayMap& rays) {
    for (std::size_t i = 0; i < 3; ++i) {
        block.entry[i] = glm::vec4(rays.entry[i], 0.0);
        block.advance[i] = glm::vec4(rays.advance[i], 0.0);
    }
}

/// Sums of weights stay below 2^32 whatever pixel the points meet in, with half a unit of rounding each.
std::uint32_t weightUnit(std::uint64_t points) {
    constexpr std::uint64_t most = 1U << 16;
    return static_cast<std::uint32_t>(
        std::clamp<std::uint64_t>(0xffffffffULL / std::max<std::uint64_t>(points, 1), 1, most));
}

}  // namespace

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
    const auto blank = blankPixel(plan.background, format);
    std::memcpy(&block.blank, blank.data(), blank.size());
    for (std::size_t i = 0; i < plan.layers.size(); ++i) {
        const LayerPlan& layer = plan.layers[i];
        const PointNumbers numbers = pointNumbers(plan, layer);
        LayerBlock& result = block.layers[i];
        result.boxToScreen = glm::mat4(boxToScreen(plan, layer));
        setRays(result, RayMap(plan, layer));
        result.point = glm::vec4(layer.style.pointColor, numbers.tau);
        result.scale = glm::vec4(1.0 / numbers.unit, volumeSizes[i], 0.0, 0.0);
    }
    return block;
}

}  // namespace mote::render
