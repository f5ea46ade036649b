// SPDX-License-Identifier: GPL-3.0-or-later
//
// Cameras that look at a mesh from anywhere, and transforms of its layer, for tests of what is drawn of it.
// Pure but for the random numbers.
#pragma once

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <vector>

#include "protocol/scene/ink_style.h"
#include "server/render/ink/raster.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/stroke_fragments.h"
#include "tests/support/random.h"

namespace mote::test {

/// Moved, turned, scaled by up to 2^40 either way, and half of them mirrored.
inline glm::dmat4 anyTransform(Random& random) {
    if (random.chance(0.4)) return glm::dmat4(1.0);
    const double scale = random.magnitude(-40, 40);
    auto transform = glm::translate(glm::dmat4(1.0), scale * random.direction());
    transform = glm::rotate(transform, random.between(-3.0, 3.0), random.direction());
    return glm::scale(transform, scale * glm::dvec3(random.sign(), 1.0, random.between(0.5, 1.5)));
}

/// Of a box in world space: from inside to far away, past its side, or the other way.
inline Camera anyCamera(Random& random, const Bounds& world) {
    const double size = glm::length(world.size());
    Camera camera;
    const glm::dvec3 aim = world.center() + random.oneOf({0.0, 0.2, 0.2, 0.5}) * size * random.direction();
    const double away = size * random.oneOf({0.05, 0.3, 0.6, 1.0, 2.0, 2.0, 4.0, 100.0});
    camera.eye = aim + away * random.direction();
    camera.target = random.chance(0.05) ? 2.0 * camera.eye - aim : aim;
    // Nothing nearer than a share of the way to the target is seen: a plane through the mesh.
    if (random.chance(0.2)) camera.target = camera.eye + random.between(500.0, 1200.0) * (aim - camera.eye);
    camera.up = random.direction();
    if (random.chance(0.4))
        camera.orthographicHeight = size * random.oneOf({0.1, 0.5, 1.0, 3.0});
    else
        camera.fovYDegrees = away > 10.0 * size ? 0.8 : random.between(10.0, 100.0);
    return camera;
}

/// As a view has it that says nothing, on light paper.
/// Lines are chosen by tone alone, and light is uneven.
inline InkStyle usualInk() {
    auto style = inkStyleOf(parseInkStyle({}, glm::dvec3(1.0)).value());
    style.silhouettes.importance = 1.0;
    style.light.ambient = 0.15;
    style.light.diffuse = 0.85;
    return style;
}

inline render::FramePlan planOf(const Camera& camera, std::uint32_t width, std::uint32_t height) {
    render::FramePlan plan;
    plan.width = width;
    plan.height = height;
    plan.camera = camera;
    return plan;
}

// What strokes cover of a picture, for tests: as devices draw them. Pure functions.

inline void addStroke(render::Strokes& strokes, const std::vector<glm::dvec2>& places, double width) {
    const auto begin = static_cast<std::uint32_t>(strokes.points.size());
    for (const auto& at : places)
        strokes.points.push_back(
            {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(width)});
    strokes.lines.push_back({begin, static_cast<std::uint32_t>(strokes.points.size())});
}

/// The share of each pixel that ink covers; strokes over one another as if independent.
inline render::Raster<double> coverOf(const render::Strokes& strokes, std::uint32_t width,
                                      std::uint32_t height) {
    render::Raster<double> bare(width, height, 1.0);
    constexpr double everywhere = -std::numeric_limits<double>::infinity();
    for (const auto& part : render::strokeFragments(strokes, width, height, everywhere)) {
        for (const auto& one : part) bare.at(one.column, one.row) *= 1.0 - static_cast<double>(one.opacity);
    }
    for (auto& value : bare.values) value = 1.0 - value;
    return bare;
}

/// Of pixels that are at least `border` from the picture's sides.
inline double meanOf(const render::Raster<double>& picture, std::uint32_t border) {
    double sum = 0.0, count = 0.0;
    for (std::uint32_t row = border; row + border < picture.height; ++row) {
        for (std::uint32_t column = border; column + border < picture.width; ++column) {
            sum += picture.at(column, row);
            count += 1.0;
        }
    }
    return sum / count;
}

}  // namespace mote::test
