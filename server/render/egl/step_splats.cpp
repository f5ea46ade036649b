// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/egl/step_splats.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/matrix.hpp>
#include <vector>

#include "server/render/device.h"

namespace mote::render {
namespace {

constexpr std::size_t codes = 256;
constexpr std::size_t opacities = codes * codes, colors = 3 * codes, shades = 2 * codes;

using PackedPoint = std::array<std::uint32_t, 3>;

PackedPoint packed(const HybridPoint& point) {
    return {point.x | std::uint32_t{point.y} << 16,
            point.z | std::uint32_t{point.value} << 16 | std::uint32_t{point.error} << 24, point.normal};
}

}  // namespace

double pointSpacing(const HybridStep& step) {
    const glm::dvec3 size(step.points->size);
    return std::cbrt(std::abs(glm::determinant(glm::dmat3(step.boxToLayer))) / (size.x * size.y * size.z));
}

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

void StepSplats::setTransfer(const HybridStep& step, const HybridTransfer& transfer) {
    const double spacing = pointSpacing(step);
    std::vector<float> values(opacities + colors);
    for (std::size_t value = 0; value < codes; ++value) {
        const double v = std::lerp(step.range.low, step.range.high, static_cast<double>(value) / 255.0);
        const double whole = transfer.extinction(v);
        for (std::size_t error = 0; error < codes; ++error) {
            const double e = (static_cast<double>(error) - 128.0) * step.points->errorStep;
            const double lack = whole > 0.0 ? std::max(0.0, whole - transfer.extinction(v - e)) : 0.0;
            values[value | error << 8] = static_cast<float>(-std::expm1(-lack * spacing));
        }
        const glm::dvec3 color = transfer.color(v);
        for (int part = 0; part < 3; ++part)
            values[opacities + 3 * value + static_cast<std::size_t>(part)] = static_cast<float>(color[part]);
    }
    look_.write(0, values.size() * sizeof(float), values.data());
}

void StepSplats::setLook(const HybridStep& step, const HybridTransfer& transfer, const HybridLight& light) {
    static_assert(sizeof(HybridLight::Shade) == 2 * sizeof(float));
    if (transfer_ != transfer) setTransfer(step, transfer);
    transfer_ = transfer;
    look_.write((opacities + colors) * sizeof(float), sizeof(light.shades()), light.shades().data());
}

}  // namespace mote::render
