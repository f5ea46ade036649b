// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/golden/golden_dots.h"

#include <cmath>
#include <glm/vec4.hpp>
#include <limits>
#include <numbers>

namespace mote::test {
namespace {

using render::Dot;
using render::Dots;

/// Turns by the golden angle fill a circle or a sphere evenly.
const double goldenAngle = std::numbers::pi * (3.0 - std::sqrt(5.0));

/// A dot at a place in the world (camera.h).
Dot dotAt(const View& view, const glm::dvec3& place) {
    const glm::dvec4 eye = view.camera.worldToEye() * glm::dvec4(place, 1.0);
    Dot dot{.depth = -eye.z};
    const double half = view.camera.halfHeight() * (view.camera.perspective() ? dot.depth : 1.0);
    dot.x = static_cast<float>(0.5 * view.width + 0.5 * view.height * eye.x / half);
    dot.y = static_cast<float>(0.5 * view.height * (1.0 - eye.y / half));
    return dot;
}

}  // namespace

std::shared_ptr<const Dots> dotsAround(const View& view) {
    constexpr int count = 1500;
    auto dots = std::make_shared<Dots>();
    for (int i = 0; i < count; ++i) {
        const double z = 1.0 - (2.0 * i + 1.0) / count;
        const double r = std::sqrt(1.0 - z * z);
        const glm::dvec3 unit(r * std::cos(goldenAngle * i), r * std::sin(goldenAngle * i), z);
        Dot dot = dotAt(view, 0.6 * unit);
        dot.radius = 1.4F;
        dot.color = {0.5F, 0.9F, 0.6F};
        dots->push_back(dot);
    }
    return dots;
}

std::shared_ptr<const Dots> dotsThrough(const View& view) {
    constexpr int count = 2500;
    auto dots = std::make_shared<Dots>();
    for (int i = 0; i < count; ++i) {
        const double r = 0.8 * std::sqrt((i + 0.5) / count);
        const double x = r * std::cos(goldenAngle * i), y = r * std::sin(goldenAngle * i);
        Dot dot = dotAt(view, {x, y, 0.5 * x - 0.3 * y});
        dot.radius = 0.2F + 0.04F * static_cast<float>(i % 97);
        dot.opacity = 0.1F + 0.9F * static_cast<float>(i % 31) / 30.0F;
        dot.color = {static_cast<float>(i % 7) / 6.0F, static_cast<float>(i % 5) / 4.0F, 0.8F};
        dots->push_back(dot);
    }
    return dots;
}

std::shared_ptr<const Dots> dotsWithoutDepth(const View& view) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    constexpr int count = 600;
    auto dots = std::make_shared<Dots>();
    for (int i = 0; i < count; ++i) {
        const double r = 0.6 * view.height * std::sqrt((i + 0.5) / count);
        Dot dot;
        dot.x = static_cast<float>(0.5 * view.width + r * std::cos(goldenAngle * i));
        dot.y = static_cast<float>(0.5 * view.height + r * std::sin(goldenAngle * i));
        dot.depth = i % 9 == 0 ? 2.5 : i % 3 == 0 ? -infinite : infinite;
        dot.radius = i % 3 == 0 ? 1.0F : 4.0F;
        dot.opacity = 0.8F;
        dot.color = i % 3 == 0 ? glm::vec3(1.0F, 0.2F, 0.1F) : glm::vec3(0.1F, 0.2F, 0.7F);
        dots->push_back(dot);
    }
    return dots;
}

}  // namespace mote::test
