// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/dot_data.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

#include "protocol/scene/fields/facts.h"
#include "protocol/scene/write_fields.h"
#include "tests/support/random.h"

namespace mote::test {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// How far beyond the picture a dot is still given.
constexpr double border = 2000.0;  // pixels

glm::dvec3 placeIn(const std::string& form, Random& random) {
    if (form == "sphere") return 0.9 * random.direction();
    const double x = random.between(-1.0, 1.0), y = random.between(-1.0, 1.0);
    return {x, y, form == "flat" ? 0.0 : 0.5 * x - 0.25 * y};
}

/// Where a place of layer space is seen; nothing beside a perspective eye or behind it.
std::optional<render::Dot> seenAt(const glm::dvec3& inLayer, const Layer& layer, const View& view) {
    if (!inAll(layer.clips(), inLayer)) return std::nullopt;
    const glm::dvec4 eye = view.camera.worldToEye() * layer.transform * glm::dvec4(inLayer, 1.0);
    const double depth = -eye.z;
    const double nearest = 1e-4 * glm::length(view.camera.target - view.camera.eye);
    if (view.camera.perspective() && !(depth > nearest)) return std::nullopt;
    const double half = view.camera.halfHeight() * (view.camera.perspective() ? depth : 1.0);
    const double x = 0.5 * view.width + 0.5 * view.height * eye.x / half;
    const double y = 0.5 * view.height * (1.0 - eye.y / half);
    if (!(std::abs(x) < border + view.width && std::abs(y) < border + view.height)) return std::nullopt;
    render::Dot dot{.x = static_cast<float>(x), .y = static_cast<float>(y), .depth = depth};
    return dot;
}

/// Anywhere in the picture, without a place in the world.
render::Dot onScreen(const std::string& form, const View& view, Random& random) {
    render::Dot dot;
    dot.x = static_cast<float>(random.between(-8.0, view.width + 8.0));
    dot.y = static_cast<float>(random.between(-8.0, view.height + 8.0));
    dot.depth = form == "backdrop" ? infinite : -infinite;
    return dot;
}

void addLook(render::Dot& dot, double value, const StippleStyle& style, double opacity) {
    const double size = lengthOf(style, style.kDotPixelsFieldNumber),
                 least = lengthOf(style, style.kLeastDotPixelsFieldNumber);
    dot.radius = static_cast<float>(0.5 * (least + value * (size - least)));
    dot.opacity = static_cast<float>(style.opacity() * opacity);
    dot.color = style.color_map().empty() ? readColor(style.color())
                                          : ColorMap::find(style.color_map()).value()(value);
}

}  // namespace

std::span<const std::string_view> dotForms() {
    static constexpr std::array<std::string_view, 5> forms{"sphere", "plane", "flat", "backdrop", "veil"};
    return forms;
}

void addDots(const std::string& form, std::uint32_t number, const Layer& layer, const View& view,
             render::Dots& dots) {
    if (!(layer.opacity > 0.0)) return;
    const StippleStyle& style = *layer.stipple();
    Random random(number + 64 * std::uint64_t{layer.step}, 3);
    const std::uint64_t count = std::array<std::uint64_t, 4>{300, 40, 1, 0}[number % 4];
    for (std::uint64_t i = 0; i < count; ++i) {
        const bool placed = form != "backdrop" && form != "veil";
        const auto dot =
            placed ? seenAt(placeIn(form, random), layer, view) : std::optional(onScreen(form, view, random));
        const double value = random.unit();
        if (!dot) continue;
        dots.push_back(*dot);
        addLook(dots.back(), value, style, layer.opacity);
    }
}

}  // namespace mote::test
