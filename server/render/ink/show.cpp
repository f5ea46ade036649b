// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/show.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <numbers>

#include "protocol/scene/srgb.h"

namespace mote::render {
namespace {

constexpr float darkest = 0.05F;  // of what is farthest

template <class T, class Color>
Raster<glm::vec3> picture(const Raster<T>& values, const Color& color) {
    Raster<glm::vec3> made(values.width, values.height);
    for (std::size_t i = 0; i < values.values.size(); ++i)
        made.values[i] = glm::clamp(glm::vec3(color(i)), 0.0F, 1.0F);
    return made;
}

glm::vec3 hue(double turn) {
    const auto part = [turn](double from) {
        return 0.5 + 0.5 * std::cos(2.0 * std::numbers::pi * (turn - from));
    };
    return srgbToLinear(glm::dvec3(part(0.0), part(1.0 / 3.0), part(2.0 / 3.0)));
}

}  // namespace

Raster<glm::vec3> greyPicture(const Raster<float>& values) {
    return picture(values, [&](std::size_t i) { return values.values[i]; });
}

Raster<glm::vec3> paperPicture(const Raster<float>& cover) {
    return picture(cover, [&](std::size_t i) { return 1.0F - cover.values[i]; });
}

Raster<glm::vec3> depthPicture(const Modalities& modalities) {
    const auto& depths = modalities.depth.values;
    float nearest = HUGE_VALF, farthest = -HUGE_VALF;
    for (const float depth : depths) {
        if (!std::isfinite(depth)) continue;
        nearest = std::min(nearest, depth);
        farthest = std::max(farthest, depth);
    }
    const float range = std::max(farthest - nearest, 1e-30F);
    return picture(modalities.depth, [&](std::size_t i) {
        return std::isfinite(depths[i]) ? 1.0F - (1.0F - darkest) * (depths[i] - nearest) / range : 0.0F;
    });
}

Raster<glm::vec3> anglePicture(const Modalities& modalities) {
    return picture(modalities.angle, [&](std::size_t i) {
        if (modalities.part.values[i] == Modalities::nothing) return glm::vec3(0.0F);
        const float angle = modalities.angle.values[i];
        return angle == 0.0F ? glm::vec3(0.5F) : hue(static_cast<double>(angle) / std::numbers::pi);
    });
}

Raster<glm::vec3> labelPicture(const Raster<std::uint32_t>& labels) {
    return picture(labels, [&](std::size_t i) {
        if (labels.values[i] == UINT32_MAX) return glm::vec3(0.0F);
        const std::uint32_t mixed = (labels.values[i] + 1U) * 2654435761U;
        return 0.25F + 0.75F * hue((mixed >> 8U) / double(1U << 24U));
    });
}

Raster<float> spread(const ToneGrid& grid, const ToneCells& cells, std::uint32_t width,
                     std::uint32_t height) {
    Raster<float> made(width, height);
    for (std::uint32_t row = 0; row < height; ++row) {
        for (std::uint32_t column = 0; column < width; ++column)
            made.at(column, row) = toneAt(grid, cells, {column + 0.5, row + 0.5});
    }
    return made;
}

}  // namespace mote::render
