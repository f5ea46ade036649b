// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/world_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include "preprocess/readers/text/number.h"
#include "protocol/scene/utf8.h"

namespace mote::prep {
namespace {

/// The two directions of each axis, the one of RAS first.
constexpr std::array<std::array<std::string_view, 2>, 3> directions{
    {{"right", "left"}, {"anterior", "posterior"}, {"superior", "inferior"}}};

/// By axis, 1 where a patient's space goes as RAS does and -1 where it goes the other way.
std::optional<glm::dvec3> signsOf(std::string_view space) {
    glm::dvec3 signs(0.0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::string_view word = space.substr(0, space.find('-'));
        const auto& two = directions[axis];
        const auto* const found = std::find(two.begin(), two.end(), word);
        if (found == two.end()) return std::nullopt;
        signs[static_cast<int>(axis)] = found == two.begin() ? 1.0 : -1.0;
        space.remove_prefix(std::min(word.size() + 1, space.size()));
    }
    return space.empty() ? std::optional(signs) : std::nullopt;
}

void scaleWorld(VolumeShape& shape, const glm::dvec3& factors) {
    for (int column = 0; column < 4; ++column) {
        for (int axis = 0; axis < 3; ++axis) {
            const double value = shape.indexToWorld[column][axis];
            // No place is at -0.
            shape.indexToWorld[column][axis] = value == 0.0 ? 0.0 : value * factors[axis];
        }
    }
}

}  // namespace

std::string longSpace(std::string_view name) {
    std::string space = lower(name);
    if (space.ends_with("-time")) space.resize(space.size() - 5);
    if (space.size() == 4 && space.back() == 't') space.pop_back();
    if (space.size() != 3) return space;
    std::string words;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto& two = directions[axis];
        const auto* const found = std::find_if(
            two.begin(), two.end(), [&](std::string_view word) { return word.front() == space[axis]; });
        if (found == two.end()) return space;
        words += fmt::format("{}{}", axis == 0 ? "" : "-", *found);
    }
    return words;
}

Status bringTo(std::string_view wanted, VolumeShape& shape) {
    if (!wanted.empty() && wanted != "ras" && wanted != "lps" && wanted != "file") {
        return invalid("space", fmt::format("\"{:.20}\" is none of ras, lps and file", wanted));
    }
    if (wanted == "file") return success();
    if (const auto signs = signsOf(shape.space)) {
        const glm::dvec3 there = wanted == "lps" ? glm::dvec3(-1.0, -1.0, 1.0) : glm::dvec3(1.0);
        scaleWorld(shape, *signs * there);
        shape.worldSpace = wanted == "lps" ? "lps" : "ras";
        return success();
    }
    if (shape.space == "3d-left-handed") {
        scaleWorld(shape, {1.0, 1.0, -1.0});
        shape.notes.emplace_back(
            "its space is left-handed: z was turned round, so that what is drawn is no mirror image");
    }
    return success();
}

}  // namespace mote::prep
