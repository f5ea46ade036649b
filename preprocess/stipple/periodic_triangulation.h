// SPDX-License-Identifier: GPL-3.0-or-later
//
// PeriodicTriangulation: the Delaunay triangulation of points on the periodic unit square, and their Voronoi
// cells, while points move and go. It is CGAL's exact one of the plane, of the points and of those of their
// copies that lie in a margin around the square. Coordinates are kept on a grid of 2^-40, so that copies lie
// exactly one period apart and the predicates see the same configuration everywhere. Move-only; one thread
// changes it, any number may look.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace mote::prep {

/// A Voronoi cell.
struct PlaneCell {
    double area = 0.0;          ///< of the unit square
    glm::dvec2 centroid{0.0};   ///< minus the point's position
    double secondMoment = 0.0;  ///< integral of the squared distance to the point
};

class PeriodicTriangulation {
  public:
    /// Points on the square, no two alike; they are taken round it and onto the grid.
    explicit PeriodicTriangulation(std::span<const glm::dvec2> positions);
    PeriodicTriangulation(PeriodicTriangulation&&) noexcept;
    ~PeriodicTriangulation();

    /// Where a point lies, not wrapped: it may have left the square.
    glm::dvec2 position(std::uint32_t point) const;

    /// Nothing where the margin is too narrow to tell: widen() helps.
    std::optional<PlaneCell> cell(std::uint32_t point) const;
    /// Twice the margin; the widest tells every cell.
    void widen();

    /// Appends the points whose cells touch this one's, itself and others as often as they do.
    void addNeighbours(std::uint32_t point, std::vector<std::uint32_t>& neighbours) const;

    /// Moves a point by a vector; nothing happens where another point lies there.
    void move(std::uint32_t point, glm::dvec2 by);
    void remove(std::uint32_t point);

  private:
    struct Mesh;
    std::unique_ptr<Mesh> mesh_;
};

}  // namespace mote::prep
