// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/step_splats.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "server/render/device.h"
#include "server/render/hybrid/point_looks.h"

namespace mote::render {
namespace {

constexpr std::size_t codes = PointLooks::codes;
constexpr std::size_t opacities = codes * codes, colors = 3 * codes, shades = 2 * codes;

using PackedPoint = std::array<std::uint32_t, 3>;

PackedPoint packed(const HybridPoint& point) {
    return {point.x | std::uint32_t{point.y} << 16,
            point.z | std::uint32_t{point.value} << 16 | std::uint32_t{point.error} << 24, point.normal};
}

}  // namespace

StepSplats::StepSplats(const HybridStep& step)
    : count_(static_cast<std::uint32_t>(step.points->points.size())) {
    GLint texels = 0;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    if (step.points->points.size() > static_cast<std::size_t>(std::max(texels, 0)))
        throw DeviceError(fmt::format("the device holds {} points of a hybrid volume, and this one has {}",
                                      texels, step.points->points.size()));
    std::vector<PackedPoint> words;
    words.reserve(count_);
    for (const auto& point : step.points->points) words.push_back(packed(point));
    points_ = GlBuffer::of(std::span<const PackedPoint>(words));
    pointsTexture_ = bufferTexture(points_, GL_RGB32UI);
    look_ = GlBuffer((opacities + colors + shades) * sizeof(float));
    lookTexture_ = bufferTexture(look_, GL_R32F);
}

void StepSplats::setTransfer(const HybridPlan& plan) {
    static_assert(sizeof(glm::vec3) == 3 * sizeof(float));
    const PointLooks looks(*plan.step, plan.transfer, plan.pointStrength());
    look_.write(0, opacities * sizeof(float), looks.opacities().data());
    look_.write(opacities * sizeof(float), colors * sizeof(float), looks.colors().data());
}

void StepSplats::setLook(const HybridPlan& plan) {
    static_assert(sizeof(HybridLight::Shade) == 2 * sizeof(float));
    if (transfer_ != plan.transfer || strength_ != plan.pointStrength()) setTransfer(plan);
    transfer_ = plan.transfer;
    strength_ = plan.pointStrength();
    const auto& shades = plan.light.shades();
    look_.write((opacities + colors) * sizeof(float), sizeof(shades), shades.data());
}

}  // namespace mote::render
