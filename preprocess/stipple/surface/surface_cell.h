// SPDX-License-Identifier: GPL-3.0-or-later
//
// Voronoi cells of points on a surface, each in the tangent plane at its point (dissertation, 2.2.2.2). The
// surface around a point is found by walking from triangle to triangle, so that sheets that lie close
// together but do not meet there never see each other; points on it are brought into the plane along their
// direction, at the length of the arc that fits their distance and the turn of the normal.
//
// SurfaceCells reads points that others own; it may be asked on any thread while nobody changes them.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "preprocess/stipple/surface/walk_mesh.h"

namespace mote::prep {

/// Which points are near a place: a hash of blocks of cubes, each cube with a list of the points
/// in it. Reading is for any thread while nobody writes.
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

/// The points of a surface while they are moved and removed: by number.
struct PointSet {
    std::vector<SurfacePoint> points;
    std::vector<glm::vec3> normals;  ///< of the surface at each, unit length
    PointGrid grid;                  ///< those that are not removed
    double spacing = 0.0;  ///< of as many points in a hexagonal grid on all of the surface; world units
};

struct SurfaceCell {
    std::vector<std::uint32_t> neighbours;  ///< whose cells touch it, counterclockwise
    glm::dvec3 toCentroid{0.0};             ///< from the point, in its tangent plane
    double area = 0.0;                      ///< square world units
    double moment = 0.0;                    ///< second moment of the area about the point
    double nearest = 0.0;  ///< distance in the plane of the nearest point; infinite without one
    std::uint32_t nearestPoint = UINT32_MAX;
    bool closed = false;    ///< by neighbours and borders, within 3.2 spacings
    bool flat = false;      ///< closed, and the plane stands for the surface: see flatEnough
    bool atBorder = false;  ///< an edge of the cell lies on a border
};

/// The plane at a point stands for the surface around it as long as no neighbour's normal differs by more
/// than 53 degrees, and no neighbour lies further than 53 degrees out of the plane, seen from the point
/// (cosine 0.6).
inline constexpr double flatEnough = 0.6;

/// What one thread needs to find cells, and where it supposes points that it has moved for itself alone.
class CellScratch {
  public:
    CellScratch(std::size_t triangles, std::size_t points) : visited_(triangles, 0), supposedIn_(points, 0) {}

    /// From now on all points lie where the set has them.
    void supposeNothing();
    /// Cells are found as if the point lay there. Less than the spacing off, or the grid does not find it.
    void suppose(std::uint32_t point, const SurfacePoint& place, const glm::vec3& normal);

  private:
    friend class SurfaceCells;

    struct Seen {
        glm::dvec2 place;
        double distance;
        std::uint32_t point;
        float flatness;
    };
    struct Border {
        glm::dvec2 a, b;
        double distance;
    };
    struct Corner {
        glm::dvec2 place;
        std::uint32_t edge;  ///< what made the side from this corner on: a point, or one of the marks below
    };

    struct Supposed {
        std::uint32_t point;
        SurfacePoint place;
        glm::vec3 normal;
    };
    const Supposed* supposed(std::uint32_t point) const {
        return supposedIn_[point] == supposition_ ? findSupposed(point) : nullptr;
    }
    const Supposed* findSupposed(std::uint32_t point) const;

    std::vector<std::uint32_t> visited_;     ///< by triangle: round_ is within reach, one more seen only
    std::vector<std::uint32_t> supposedIn_;  ///< by point, the supposition in which it was moved
    std::uint32_t supposition_ = 1;
    std::vector<Supposed> supposed_;
    std::uint32_t round_ = 0;
    std::vector<std::uint32_t> front_;
    std::vector<std::uint32_t> beyond_;  ///< triangles beyond the radius, next to those within
    std::vector<Seen> seen_;
    std::vector<Border> borders_;
    std::vector<Corner> polygon_;
    std::vector<Corner> clipped_;
};

class SurfaceCells {
  public:
    static constexpr std::uint32_t none = UINT32_MAX;

    SurfaceCells(const WalkMesh& mesh, const PointSet& set) : mesh_(mesh), set_(set) {}

    /// The cell of a point, as if `without` were not there. `cell` keeps its memory from call to call.
    void find(std::uint32_t point, std::uint32_t without, CellScratch& scratch, SurfaceCell& cell) const;

  private:
    struct Frame {
        glm::dvec3 origin, normal, x, y;
        std::uint32_t triangle;
    };

    Frame frameAt(std::uint32_t point, const CellScratch& scratch) const;
    static void beginWalk(const Frame& frame, CellScratch& scratch);
    void walkAround(const Frame& frame, double radius, CellScratch& scratch) const;
    void noteBorder(const Frame& frame, std::uint32_t triangle, std::uint32_t side,
                    CellScratch& scratch) const;
    void look(const Frame& frame, std::uint32_t point, std::uint32_t without, double radius,
              CellScratch& scratch) const;
    bool clip(double radius, CellScratch& scratch) const;
    void measure(const Frame& frame, CellScratch& scratch, SurfaceCell& cell) const;

    const WalkMesh& mesh_;
    const PointSet& set_;
};

}  // namespace mote::prep
