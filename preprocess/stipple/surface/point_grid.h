// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointGrid: which points are near a place: a hash of blocks of cubes, each cube with a list of the points in
// it. Reading is for any thread while nobody writes.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace mote::prep {

class PointGrid {
  public:
    static constexpr std::uint32_t none = UINT32_MAX;

    /// A grid for points 0 to `points`, of which about `expected` are in it at once; `cell`: a cube's edge,
    /// world units.
    PointGrid(std::size_t points, std::size_t expected, double cell)
        : cell_(cell),
          mask_(std::bit_ceil(std::max<std::size_t>(expected / 4, 16)) - 1),
          heads_(cubesInBlock * (mask_ + 1), none),
          next_(points, none),
          previous_(points, none) {}

    void add(std::uint32_t point, const glm::dvec3& position) {
        auto& head = heads_[slot(cubeOf(position))];
        next_[point] = head;
        previous_[point] = none;
        if (head != none) previous_[head] = point;
        head = point;
    }
    /// `position` is the one that it was added with.
    void remove(std::uint32_t point, const glm::dvec3& position) {
        const auto next = next_[point];
        const auto previous = previous_[point];
        if (next != none) previous_[next] = previous;
        (previous == none ? heads_[slot(cubeOf(position))] : next_[previous]) = next;
    }
    void move(std::uint32_t point, const glm::dvec3& from, const glm::dvec3& to) {
        if (slot(cubeOf(from)) == slot(cubeOf(to))) return;
        remove(point, from);
        add(point, to);
    }

    /// Calls `visit` with every point within `radius`, and with others: cubes that share a list, and what
    /// lies further off in a cube. A point may come twice where two cubes share a list.
    template <class Visit>
    void near(const glm::dvec3& place, double radius, Visit&& visit) const {
        const auto low = cubeOf(place - glm::dvec3(radius));
        const auto high = cubeOf(place + glm::dvec3(radius));
        for (auto z = low.z; z <= high.z; ++z) {
            const double offZ = off(place.z, z);
            for (auto y = low.y; y <= high.y; ++y) {
                const double offY = off(place.y, y);
                const double left = radius * radius - offY * offY - offZ * offZ;
                if (left < 0.0) continue;
                const double half = std::sqrt(left);
                const auto last = indexOf(place.x + half);
                for (auto x = indexOf(place.x - half); x <= last; ++x) {
                    for (auto p = heads_[slot({x, y, z})]; p != none; p = next_[p]) visit(p);
                }
            }
        }
    }

  private:
    struct Cube {
        std::int64_t x, y, z;
    };

    /// How far a coordinate lies off the cube of this index.
    double off(double coordinate, std::int64_t index) const {
        const double low = static_cast<double>(index) * cell_;
        return std::max({low - coordinate, coordinate - low - cell_, 0.0});
    }
    std::int64_t indexOf(double coordinate) const {
        return static_cast<std::int64_t>(std::floor(coordinate / cell_));
    }
    Cube cubeOf(const glm::dvec3& position) const {
        return {indexOf(position.x), indexOf(position.y), indexOf(position.z)};
    }
    std::size_t slot(const Cube& cube) const {
        auto hash = static_cast<std::uint64_t>(cube.z >> 1) * 0x9e3779b97f4a7c15ULL;
        hash = (hash ^ static_cast<std::uint64_t>(cube.y >> 1)) * 0xbf58476d1ce4e5b9ULL;
        hash = (hash ^ static_cast<std::uint64_t>(cube.x >> 2)) * 0x94d049bb133111ebULL;
        const auto within = (cube.x & 3) | (cube.y & 1) << 2 | (cube.z & 1) << 3;
        return cubesInBlock * (static_cast<std::size_t>(hash >> 32) & mask_) +
               static_cast<std::size_t>(within);
    }

    /// Four by two by two, which is one cache line.
    static constexpr std::size_t cubesInBlock = 16;

    double cell_;
    std::size_t mask_;
    std::vector<std::uint32_t> heads_;
    std::vector<std::uint32_t> next_;
    std::vector<std::uint32_t> previous_;
};

}  // namespace mote::prep
