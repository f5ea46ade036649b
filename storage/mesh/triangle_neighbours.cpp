// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/mesh/triangle_neighbours.h"

#include <algorithm>
#include <tuple>

namespace mote::storage {
namespace {

/// One side of a triangle, by the edge it lies at.
struct Side {
    std::uint32_t low, high;  ///< vertices
    std::uint32_t triangle;
    std::uint32_t corner;  ///< where the side begins

    friend bool operator<(const Side& a, const Side& b) {
        return std::tie(a.low, a.high, a.triangle, a.corner) < std::tie(b.low, b.high, b.triangle, b.corner);
    }
    bool sameEdge(const Side& other) const { return low == other.low && high == other.high; }
};

std::vector<Side> sortedSides(const Triangles& triangles) {
    std::vector<Side> sides;
    sides.reserve(3 * triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const auto [low, high] = std::minmax(triangles[t][i], triangles[t][(i + 1) % 3]);
            sides.push_back({low, high, t, i});
        }
    }
    std::sort(sides.begin(), sides.end());
    return sides;
}

}  // namespace

TriangleNeighbours findNeighbours(const Triangles& triangles) {
    TriangleNeighbours neighbours(triangles.size(), {MeshEdge::none, MeshEdge::none, MeshEdge::none});
    const auto sides = sortedSides(triangles);
    for (std::size_t begin = 0; begin < sides.size();) {
        std::size_t end = begin + 1;
        while (end < sides.size() && sides[end].sameEdge(sides[begin])) ++end;
        if (end - begin == 2) {
            const auto& a = sides[begin];
            const auto& b = sides[begin + 1];
            neighbours[a.triangle][a.corner] = b.triangle;
            neighbours[b.triangle][b.corner] = a.triangle;
        }
        begin = end;
    }
    return neighbours;
}

std::vector<MeshEdge> edgesOf(const Triangles& triangles, const TriangleNeighbours& neighbours) {
    std::vector<MeshEdge> edges;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const auto other = neighbours[t][i];
            if (other < t) continue;
            edges.push_back({{triangles[t][i], triangles[t][(i + 1) % 3]}, {t, other}});
        }
    }
    return edges;
}

}  // namespace mote::storage
