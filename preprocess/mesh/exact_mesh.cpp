// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "preprocess/mesh/triangle_mesh.h"

namespace mote::prep {
namespace {

constexpr double floatStep = 0x1p-23;   // of a number, over it
constexpr double greatestStep = 1e-5;   // over the longest side
constexpr double greatestPlace = 1e18;  // what lies further is left out later (storage/places.h)

bool isNear(const glm::dvec3& place) {
    return std::abs(place.x) < greatestPlace && std::abs(place.y) < greatestPlace &&
           std::abs(place.z) < greatestPlace;
}

}  // namespace

glm::dvec3 originFor(const glm::dvec3& low, const glm::dvec3& high) {
    double longest = 0.0, furthest = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        longest = std::max(longest, high[axis] - low[axis]);
        furthest = std::max({furthest, std::abs(low[axis]), std::abs(high[axis])});
    }
    glm::dvec3 origin(0.0);
    if (!(longest > 0.0) || !(furthest * floatStep > greatestStep * longest)) return origin;
    const double grain = std::pow(10.0, std::floor(std::log10(longest)));
    for (int axis = 0; axis < 3; ++axis) {
        const double middle = low[axis] + (high[axis] - low[axis]) / 2.0;
        if (std::abs(middle) > longest) origin[axis] = std::round(middle / grain) * grain;
    }
    return origin;
}

TriangleMesh toFloats(ExactMesh mesh) {
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
    for (const auto& triangle : mesh.triangles) {
        for (const auto corner : triangle) {
            const auto& place = mesh.positions[corner];
            if (!isNear(place)) continue;
            low = glm::min(low, place);
            high = glm::max(high, place);
        }
    }
    TriangleMesh made;
    if (low.x <= high.x) made.origin = originFor(low, high);
    made.positions.reserve(mesh.positions.size());
    for (const auto& place : mesh.positions) made.positions.emplace_back(place - made.origin);
    made.triangles = std::move(mesh.triangles);
    made.parts = std::move(mesh.parts);
    made.smallFaces = mesh.smallFaces;
    made.tangled = mesh.tangled;
    made.notes = std::move(mesh.notes);
    return made;
}

std::string describeOrigin(const glm::dvec3& origin) {
    if (origin == glm::dvec3(0.0)) return "";
    return fmt::format(
        "({:.15g}, {:.15g}, {:.15g}) was taken off all places, which lie too far from 0 for floats: add it "
        "to have "
        "the file's own",
        origin.x, origin.y, origin.z);
}

}  // namespace mote::prep
