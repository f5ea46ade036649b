// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/quick_lines.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace mote::render {
namespace {

constexpr double partLength = 2.0;  // pixels of an edge that are seen or not as one
constexpr double mostParts = 4096.0;
constexpr double beside = 1.0;     // pixels from a line at which what lies there is measured
constexpr double gapShare = 2e-3;  // of the extent: what is so little nearer hides nothing

/// The same number, 0 to 1, of an edge in every picture.
float rankOf(const EdgeLine& edge) {
    std::uint64_t mixed = (std::uint64_t{edge.triangles[0]} << 32U | edge.vertices[0]) ^
                          (std::uint64_t{edge.vertices[1]} << 16U);
    mixed = (mixed ^ (mixed >> 30U)) * 0xBF58476D1CE4E5B9U;
    mixed = (mixed ^ (mixed >> 27U)) * 0x94D049BB133111EBU;
    return static_cast<float>((mixed ^ (mixed >> 31U)) >> 40U) * 0x1p-24F;
}

class QuickFinder {
  public:
    QuickFinder(const MeshSurface& surface, const LineView& view, const Modalities& modalities)
        : surface_(surface), view_(view), depth_(modalities.depth), extent_(modalities.extent) {}

    void find(const EdgeLine& edge, std::vector<InkLine>& lines) const {
        const Ends ends = partOf(endsOf(surface_, edge, view_), edge.piece);
        const glm::dvec3 &from = ends.from, &to = ends.to;
        const glm::dvec2 a = view_.onScreen(from), b = view_.onScreen(to);
        const double parts = std::clamp(std::ceil(glm::distance(a, b) / partLength), 1.0, mostParts);
        const auto placeAt = [&](double share) {
            const glm::dvec3 place = from + view_.alongLine(from, to, share) * (to - from);
            return LinePoint{view_.onScreen(place), -place.z};
        };
        InkLine line{edge.kind, {}, rankOf(edge)};
        for (double part = 0.0; part < parts; ++part) {
            const auto middle = placeAt((part + 0.5) / parts);
            if (!seen(middle, edge.kind, b - a)) {
                end(line, lines);
                continue;
            }
            if (line.points.empty()) line.points.push_back(placeAt(part / parts));
            line.points.back().step = stepBeside(middle, b - a);
            line.points.push_back(placeAt((part + 1.0) / parts));
            line.points.back().step = line.points.front().step;
        }
        end(line, lines);
    }

  private:
    static void end(InkLine& line, std::vector<InkLine>& lines) {
        if (!line.points.empty()) lines.push_back(line);
        line.points.clear();
    }
    /// In the pixel of a silhouette the surface may bulge before it; beside it, it does not.
    bool seen(const LinePoint& place, LineKind kind, const glm::dvec2& way) const {
        const double least = place.depth - gapShare * extent_;
        return depthAt(place.at) >= least || (kind == LineKind::silhouette && farthest(place, way) >= least);
    }
    double stepBeside(const LinePoint& place, const glm::dvec2& way) const {
        return std::clamp((farthest(place, way) - place.depth) / extent_, 0.0, 1.0);
    }
    /// Of what lies beside a line.
    double farthest(const LinePoint& place, const glm::dvec2& way) const {
        const double length = glm::length(way);
        if (!(length > 0.0)) return place.depth;
        const glm::dvec2 across = beside / length * glm::dvec2(-way.y, way.x);
        return std::max(depthAt(place.at + across), depthAt(place.at - across));
    }
    double depthAt(const glm::dvec2& place) const {
        return static_cast<double>(depth_.near(place.x, place.y));
    }

    const MeshSurface& surface_;
    const LineView& view_;
    const Raster<float>& depth_;
    const double extent_;
};

}  // namespace

std::vector<InkLine> quickLines(const MeshSurface& surface, const LineView& view,
                                const std::vector<EdgeLine>& edges, const Modalities& modalities,
                                const std::stop_token& stop) {
    const QuickFinder finder(surface, view, modalities);
    return inOrder<InkLine>(edges.size(), stop, [&](std::size_t first, std::size_t last, auto& lines) {
        for (std::size_t i = first; i < last; ++i) finder.find(edges[i], lines);
    });
}

}  // namespace mote::render
