// SPDX-License-Identifier: GPL-3.0-or-later
//
// PolygonIndex: which places lie within a closed line that may cross itself, by the even-odd rule, quickly
// also where it has 10^5 corners. Immutable; any number of threads.
//
// The rule, to the last bit: of an edge, a is the end of lesser y and b the other. It counts at (x, y) where
// a.y <= y < b.y and x < clamp(a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y))) in doubles, clamped to the x of
// its ends. Within is where an odd number of edges count. So a place on a lower or left side is within, one
// on an upper or right side is not, and polygons that share a side share no place. A NaN lies nowhere.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace mote::storage {

class PolygonIndex {
  public:
    /// Finite corners, of which the last is joined to the first.
    explicit PolygonIndex(std::span<const glm::dvec2> corners);

    bool contains(double x, double y) const;

    std::uint64_t bytes() const;

  private:
    struct Edge {
        double ax, ay, bx, by;  ///< ay < by
        double low, high;       ///< of ax and bx
    };
    /// Where edges meet: from its y on another number of edges counts.
    struct Joint {
        std::size_t first, second;  ///< edges
        double y;
    };
    struct Span {
        std::uint32_t first, last;  ///< cells of a row
    };

    void makeEdges(std::span<const glm::dvec2> corners);
    bool fits(std::uint32_t cells) const;
    void fill();
    Span columnsOf(const Edge& edge, std::uint32_t row) const;
    std::uint32_t row(double y) const { return cell(y, lowY_, scaleY_); }
    std::uint32_t column(double x) const { return cell(x, lowX_, scaleX_); }
    std::uint32_t cell(double value, double low, double scale) const;
    bool counts(const Edge& edge, double x, double y) const;

    std::vector<Edge> edges_;  ///< none of them level
    std::vector<Joint> joints_;
    double lowX_ = 0.0, lowY_ = 0.0, highX_ = 0.0, highY_ = 0.0;
    double scaleX_ = 0.0, scaleY_ = 0.0;    ///< cells a unit
    double marginX_ = 0.0, marginY_ = 0.0;  ///< more than rounding moves an edge
    std::uint32_t cells_ = 1;               ///< along each side
    // By cell, row after row: the parity of all that lies wholly to its right, and what must be looked at.
    std::vector<std::uint8_t> parity_;
    std::vector<std::uint32_t> begin_;    ///< in entries_, and the end
    std::vector<std::uint32_t> entries_;  ///< edges; from edges_.size() on joints
};

}  // namespace mote::storage
