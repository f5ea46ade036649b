// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/mesh/triangle_intersection.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <tuple>
#include <utility>

namespace mote::storage {
namespace {

constexpr double floatSteps = 0x1p-22;  // four steps of a float, of the greatest coordinate
constexpr int gridBits = 40;            // below the greatest coordinate: ends that differ by rounding are one

using TriangleCorners = std::array<glm::dvec3, 3>;
using CornerHeights = std::array<double, 3>;

bool sharesEdge(const TriangleCorners& a, const TriangleCorners& b) {
    const auto shared = std::count_if(a.begin(), a.end(), [&](const glm::dvec3& corner) {
        return corner == b[0] || corner == b[1] || corner == b[2];
    });
    return shared >= 2;
}

/// Whether some of a triangle lies below a plane and some above it or in it.
bool isParted(const CornerHeights& heights) {
    const auto below =
        std::count_if(heights.begin(), heights.end(), [](double height) { return height < 0.0; });
    return below == 1 || below == 2;
}

/// Where a side of a triangle goes through a plane; the same from whichever end it is told.
glm::dvec3 placeInPlane(glm::dvec3 from, double fromHeight, glm::dvec3 to, double toHeight) {
    if (fromHeight == 0.0) return from;
    if (toHeight == 0.0) return to;
    if (std::tie(to.x, to.y, to.z) < std::tie(from.x, from.y, from.z)) {
        std::swap(from, to);
        std::swap(fromHeight, toHeight);
    }
    return from + fromHeight / (fromHeight - toHeight) * (to - from);
}

/// What of a triangle that is parted lies in the plane.
std::array<glm::dvec3, 2> sectionOf(const TriangleCorners& corners, const CornerHeights& heights) {
    std::size_t lone = 0;
    while ((heights[(lone + 1) % 3] < 0.0) != (heights[(lone + 2) % 3] < 0.0)) ++lone;
    const auto to = [&](std::size_t corner) {
        return placeInPlane(corners[lone], heights[lone], corners[corner % 3], heights[corner % 3]);
    };
    return {to(lone + 1), to(lone + 2)};
}

}  // namespace

TriangleIntersections::TriangleIntersections(const SurfaceMesh& mesh) : mesh_(mesh) {
    float greatest = 0.0F;
    for (const auto& at : mesh.positions)
        greatest = std::max({greatest, std::abs(at.x), std::abs(at.y), std::abs(at.z)});
    tolerance_ = floatSteps * static_cast<double>(greatest);
    if (greatest > 0.0F) grid_ = std::ldexp(1.0, std::ilogb(greatest) - gridBits);
}

TriangleIntersections::Corners TriangleIntersections::cornersOf(std::uint32_t triangle) const {
    const auto [a, b, c] = mesh_.triangles[triangle];
    return {mesh_.positions[a], mesh_.positions[b], mesh_.positions[c]};
}

std::array<double, 3> TriangleIntersections::heights(std::uint32_t triangle, std::uint32_t plane) const {
    const auto [a, b, c] = cornersOf(plane);
    const glm::dvec3 area = glm::cross(b - a, c - a);
    const double length = glm::length(area);
    std::array<double, 3> made{};
    if (!(length > 0.0)) return made;
    const auto corners = cornersOf(triangle);
    for (std::size_t i = 0; i < 3; ++i) {
        const double height = glm::dot(area, corners[i] - a) / length;
        if (std::abs(height) > tolerance_) made[i] = height;
    }
    return made;
}

std::optional<std::array<glm::dvec3, 2>> TriangleIntersections::between(std::uint32_t one,
                                                                        std::uint32_t other) const {
    const auto a = cornersOf(one), b = cornersOf(other);
    if (sharesEdge(a, b)) return std::nullopt;
    const auto aHeights = heights(one, other);
    if (!isParted(aHeights)) return std::nullopt;
    const auto bHeights = heights(other, one);
    if (!isParted(bHeights)) return std::nullopt;
    // Both lie on the line that the planes have in common.
    auto first = sectionOf(a, aHeights), second = sectionOf(b, bHeights);
    if (glm::distance(first[0], first[1]) < glm::distance(second[0], second[1])) std::swap(first, second);
    const glm::dvec3 way = first[1] - first[0];
    if (glm::dot(second[1] - second[0], way) < 0.0) std::swap(second[0], second[1]);
    const auto along = [&](const glm::dvec3& at) { return glm::dot(at - first[0], way); };
    const glm::dvec3 begin = along(second[0]) > along(first[0]) ? second[0] : first[0];
    const glm::dvec3 end = along(second[1]) < along(first[1]) ? second[1] : first[1];
    if (!(along(end) - along(begin) > tolerance_ * glm::length(way))) return std::nullopt;
    return std::array{glm::round(begin / grid_) * grid_, glm::round(end / grid_) * grid_};
}

}  // namespace mote::storage
