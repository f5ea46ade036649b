// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/hybrid/normal_table.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>

namespace mote::storage {
namespace {

constexpr int mapSize = 64;  ///< cells of the octahedral map, a side

/// The place of a direction, a vector of any length but 0, in [-1, 1]^2 (Meyer et al. 2010, On floating-point
/// normal vectors).
glm::vec2 octahedral(const glm::vec3& v) {
    const float sum = std::abs(v.x) + std::abs(v.y) + std::abs(v.z);
    const glm::vec2 p(v.x / sum, v.y / sum);
    if (v.z >= 0.0F) return p;
    return {std::copysign(1.0F - std::abs(p.y), p.x), std::copysign(1.0F - std::abs(p.x), p.y)};
}

glm::vec3 fromOctahedral(const glm::vec2& p) {
    glm::vec3 v(p.x, p.y, 1.0F - std::abs(p.x) - std::abs(p.y));
    if (v.z < 0.0F) {
        v.x = std::copysign(1.0F - std::abs(p.y), p.x);
        v.y = std::copysign(1.0F - std::abs(p.x), p.y);
    }
    return glm::normalize(v);
}

/// `place` in cells.
glm::vec3 inMap(const glm::vec2& place) {
    return fromOctahedral(place * (2.0F / mapSize) - 1.0F);
}

/// How far the furthest direction of a cell is from its centre. The octahedron's edges lie on edges and
/// diagonals of cells, so that a cell or either half of it is a flat piece of it: what lies furthest is a
/// corner. What is nearest to some direction in the cell is at most twice that further from the centre than
/// what is nearest there.
float radius(const glm::vec2& corner, const glm::vec3& centre) {
    float greatest = 0.0F;
    for (const auto& step : {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(0, 1), glm::vec2(1, 1)})
        greatest = std::max(greatest, glm::distance(inMap(corner + step), centre));
    return greatest;
}

int cellOf(const glm::vec3& v) {
    const auto p = octahedral(v);
    const auto index = [](float x) {
        return std::clamp(static_cast<int>((x + 1.0F) * 0.5F * mapSize), 0, mapSize - 1);
    };
    return index(p.y) * mapSize + index(p.x);
}

/// Spherical Fibonacci points: direction i of n lies at the height 1 - (2i + 1) / n, a golden angle on from
/// the one before (Swinbank and Purser 2006, Fibonacci grids).
glm::vec3 fibonacci(int i, int n) {
    const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double z = 1.0 - (2.0 * i + 1.0) / n;
    const double r = std::sqrt(1.0 - z * z);
    return {static_cast<float>(r * std::cos(golden * i)), static_cast<float>(r * std::sin(golden * i)),
            static_cast<float>(z)};
}

}  // namespace

NormalTable::NormalTable() {
    for (int i = 0; i < directions; ++i)
        directions_[static_cast<std::size_t>(i) + 1] = fibonacci(i, directions);
    for (int cell = 0; cell < mapSize * mapSize; ++cell) {
        const glm::vec2 corner(cell % mapSize, cell / mapSize);
        const auto centre = inMap(corner + 0.5F);
        const float slack = 2.0F * radius(corner, centre) + 1e-5F;  // floats round
        std::array<float, directions + 1> distance{};
        for (std::size_t i = 1; i <= directions; ++i) distance[i] = glm::distance(centre, directions_[i]);
        const float least = *std::min_element(distance.begin() + 1, distance.end());
        nearbyBegin_.push_back(static_cast<std::uint32_t>(nearby_.size()));
        for (std::size_t i = 1; i <= directions; ++i) {
            if (distance[i] <= least + slack) nearby_.push_back(static_cast<std::uint8_t>(i));
        }
    }
    nearbyBegin_.push_back(static_cast<std::uint32_t>(nearby_.size()));
}

std::uint8_t NormalTable::code(const glm::vec3& vector) const {
    const float sum = std::abs(vector.x) + std::abs(vector.y) + std::abs(vector.z);
    if (!(sum > 0.0F && std::isfinite(sum))) return none;
    const auto unit = vector / sum;
    const auto cell = static_cast<std::size_t>(cellOf(unit));
    std::uint8_t best = none;
    float greatest = -2.0F;
    for (auto i = nearbyBegin_[cell]; i < nearbyBegin_[cell + 1]; ++i) {
        const float cosine = glm::dot(unit, directions_[nearby_[i]]);
        if (cosine <= greatest) continue;
        greatest = cosine;
        best = nearby_[i];
    }
    return best;
}

}  // namespace mote::storage
