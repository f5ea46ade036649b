// SPDX-License-Identifier: GPL-3.0-or-later
//
// Voronoi cells of points on a surface, each in the tangent plane at its point (dissertation, 2.2.2.2). The
// surface around a point is found by walking from triangle to triangle, so that sheets that lie close
// together but do not meet there never see each other; points on it are brought into the plane along their
// direction, at the length of the arc that fits their distance and the turn of the normal.
//
// SurfaceCells reads points that others own; it may be asked on any thread while nobody changes them.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

#include "preprocess/stipple/surface/point_grid.h"
#include "preprocess/stipple/surface/walk_mesh.h"

namespace mote::prep {

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
