// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/mesh_lines.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "server/render/plan/in_turns.h"

namespace mote::render {
namespace {

glm::dvec3 area(const storage::SurfaceMesh& mesh, std::uint32_t triangle) {
    const auto [i, j, k] = mesh.triangles[triangle];
    const glm::dvec3 a(mesh.positions[i]);
    return glm::cross(glm::dvec3(mesh.positions[j]) - a, glm::dvec3(mesh.positions[k]) - a);
}

/// On which side of each triangle the eye is: 1, -1, or 0.
std::vector<std::int8_t> facings(const storage::SurfaceMesh& mesh, const LineView& view) {
    std::vector<std::int8_t> sides(mesh.triangles.size());
    forRangesInTurns(sides.size(), 1024, [&](const auto& range) {
        for (auto i = range.begin(); i < range.end(); ++i) {
            const auto [a, b, c] = mesh.triangles[i];
            const double side = view.facing(mesh.positions[a], mesh.positions[b], mesh.positions[c]);
            sides[i] = static_cast<std::int8_t>((side > 0.0) - (side < 0.0));
        }
    });
    return sides;
}

class LineFinder {
  public:
    LineFinder(const MeshSurface& surface, const LineView& view, double crease)
        : surface_(surface),
          mesh_(surface.mesh()),
          view_(view),
          creases_(crease < 180.0),
          leastCosine_(std::cos(crease * std::numbers::pi / 180.0)),
          sides_(facings(mesh_, view)) {}

    std::size_t count() const { return mesh_.edges.size() + (creases_ ? mesh_.intersections.size() : 0); }

    void find(std::size_t first, std::size_t last, std::vector<EdgeLine>& lines) const {
        for (std::size_t i = first; i < last; ++i) {
            EdgeLine line = i < mesh_.edges.size() ? edgeOf(i) : intersectionOf(i - mesh_.edges.size());
            if (i < mesh_.edges.size() && !isLine(mesh_.edges[i], line.kind)) continue;
            const auto [from, to] = endsOf(surface_, line, view_);
            line.piece = view_.inPicture(from, to, lineMargin);
            if (!line.piece.empty()) lines.push_back(line);
        }
    }

  private:
    EdgeLine edgeOf(std::size_t number) const {
        const auto& edge = mesh_.edges[number];
        return {.vertices = edge.vertices, .triangles = edge.triangles};
    }
    EdgeLine intersectionOf(std::size_t number) const {
        const auto first = static_cast<std::uint32_t>(mesh_.positions.size() + 2 * number);
        return {.kind = LineKind::crease,
                .vertices = {first, first + 1},
                .triangles = mesh_.intersections[number]};
    }
    bool isLine(const storage::MeshEdge& edge, LineKind& kind) const {
        const auto [one, other] = edge.triangles;
        if (one == storage::MeshEdge::none || other == storage::MeshEdge::none) {
            kind = LineKind::border;
            return true;
        }
        // Where one is seen edge-on it counts with those that are seen.
        if ((sides_[one] < 0) != (sides_[other] < 0)) {
            kind = LineKind::silhouette;
            return true;
        }
        kind = LineKind::crease;
        return creases_ && bends(one, other);
    }
    bool bends(std::uint32_t one, std::uint32_t other) const {
        const glm::dvec3 a = area(mesh_, one), b = area(mesh_, other);
        const double lengths = glm::length(a) * glm::length(b);
        return lengths > 0.0 && glm::dot(a, b) <= leastCosine_ * lengths;
    }

    const MeshSurface& surface_;
    const storage::SurfaceMesh& mesh_;
    const LineView& view_;
    const bool creases_;
    const double leastCosine_;
    std::vector<std::int8_t> sides_;
};

}  // namespace

std::vector<EdgeLine> linesOf(const MeshSurface& surface, const LineView& view, double crease,
                              const std::stop_token& stop) {
    const LineFinder finder(surface, view, crease);
    return inOrder<EdgeLine>(finder.count(), stop, [&](std::size_t first, std::size_t last, auto& lines) {
        finder.find(first, last, lines);
    });
}

}  // namespace mote::render
