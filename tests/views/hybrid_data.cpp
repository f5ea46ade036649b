// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/hybrid_data.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "tests/support/random.h"

namespace mote::test {
namespace {

/// A skull around a brain, in Hounsfield units where air is 0 and bone is 1.
double head(const glm::dvec3& inBox) {
    const double radius = glm::length((inBox - 0.5) / glm::dvec3(0.36, 0.44, 0.4));
    const double bone = std::clamp(0.5 - 30.0 * (std::abs(radius - 0.9) - 0.06), 0.0, 1.0);
    const double tissue = radius < 1.0 ? 0.3 : 0.0;
    return std::max(bone, tissue + 0.02 * std::sin(40.0 * inBox.x));
}

/// A hash of the cell of 1/24 that a place lies in.
double noise(const glm::dvec3& inBox, std::uint64_t seed) {
    const glm::dvec3 cell = glm::floor(glm::clamp(inBox, 0.0, 1.0) * 24.0);
    Random random(seed, static_cast<std::uint64_t>(cell.x + 32.0 * (cell.y + 32.0 * cell.z)));
    return random.unit();
}

double unitValue(const std::string& form, std::uint32_t number, std::uint32_t step, const glm::dvec3& inBox) {
    if (form == "constant") return std::array{0.0, 0.5, 1.0}[number % 3];
    if (form == "noise") return noise(inBox, number + 10 * step);
    if (form == "head") return head(inBox);
    const double shift = 0.05 * step;
    return std::clamp(machineParts(inBox + glm::dvec3(shift, 0.0, 0.0)), 0.0, 1.0);
}

glm::dmat4 boxOf(std::uint32_t number, const glm::uvec3& source) {
    const glm::dvec3 edges = glm::dvec3(source) * std::array{8.0, 0.05, 0.8, 1e-3}[number % 4];
    const glm::dvec3 offset = number % 2 == 0 ? -0.5 * edges : glm::dvec3(10.0, -5.0, 20.0);
    glm::dmat4 box = glm::translate(glm::dmat4(1.0), offset);
    if (number % 5 == 3) box = glm::rotate(box, 0.4, glm::normalize(glm::dvec3(0.2, 1.0, 0.1)));
    return glm::scale(box, edges);
}

}  // namespace

std::span<const std::string_view> hybridForms() {
    static constexpr std::array<std::string_view, 8> forms{"machine", "machine",  "head",   "noise",
                                                           "sheet",   "constant", "single", "long"};
    return forms;
}

HybridShape hybridShape(const std::string& form, std::uint32_t number) {
    HybridShape shape{.source = {32, 26, 20}, .low = {8, 7, 5}};
    if (form == "head") shape.source = {40, 40, 15}, shape.low = {10, 10, 5};
    if (form == "noise") shape.source = {13, 13, 13}, shape.low = {5, 5, 5};
    if (form == "sheet") shape.source = {1, 30, 24}, shape.low = {1, 8, 6};
    if (form == "single") shape.source = shape.low = glm::uvec3(1);
    if (form == "long") shape.source = {200, 3, 2}, shape.low = {50, 1, 1};
    shape.boxToLayer = boxOf(number, shape.source);
    const std::array<ValueRange, 4> ranges{{{-1000.0, 3000.0}, {0.0, 1.0}, {2.0, 202.0}, {1e-9, 3e-9}}};
    shape.range = ranges[number / 2 % 4];
    shape.threshold = 0.06 * (shape.range.high - shape.range.low);
    using enum HybridRepresentation;
    shape.parts = std::array{residual, points, residual, points, volume}[number % 5];
    return shape;
}

std::shared_ptr<const render::GridField> hybridStep(const std::string& form, std::uint32_t number,
                                                    std::uint32_t step) {
    const HybridShape shape = hybridShape(form, number);
    return hybridOf(shape, [&](const glm::dvec3& at) {
        return glm::mix(shape.range.low, shape.range.high, unitValue(form, number, step, at));
    });
}

}  // namespace mote::test
