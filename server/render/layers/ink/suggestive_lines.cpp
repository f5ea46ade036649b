// SPDX-License-Identifier: GPL-3.0-or-later
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "server/render/layers/ink/mesh_lines.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

using glm::dvec3;

constexpr std::size_t atATime = 1024;  // triangles or vertices of a task
// By how much the radial curvature grows towards the eye where a line is drawn, of the square of the
// surface's median curvature, by the cosine that it is seen at.
constexpr double leastGrowth = 0.6;
constexpr double leastSine = 0.34, leastCosine = 0.05;  // of normals to the way to the eye, where it is told

/// How normals turn along a surface: symmetric, of directions in layer space, 1 by its unit.
struct Shape {
    float xx = 0.0F, yy = 0.0F, zz = 0.0F, xy = 0.0F, xz = 0.0F, yz = 0.0F;

    void add(const dvec3& a, const dvec3& b, double share) {
        xx += static_cast<float>(share * a.x * b.x);
        yy += static_cast<float>(share * a.y * b.y);
        zz += static_cast<float>(share * a.z * b.z);
        xy += static_cast<float>(0.5 * share * (a.x * b.y + a.y * b.x));
        xz += static_cast<float>(0.5 * share * (a.x * b.z + a.z * b.x));
        yz += static_cast<float>(0.5 * share * (a.y * b.z + a.z * b.y));
    }
    void add(const Shape& other) {
        xx += other.xx;
        yy += other.yy;
        zz += other.zz;
        xy += other.xy;
        xz += other.xz;
        yz += other.yz;
    }
    void scale(float by) {
        for (float* part : {&xx, &yy, &zz, &xy, &xz, &yz}) *part *= by;
    }
    double along(const dvec3& w) const {
        return w.x * w.x * static_cast<double>(xx) + w.y * w.y * static_cast<double>(yy) +
               w.z * w.z * static_cast<double>(zz) +
               2.0 * (w.x * w.y * static_cast<double>(xy) + w.x * w.z * static_cast<double>(xz) +
                      w.y * w.z * static_cast<double>(yz));
    }
    /// The root of the sum of the squares of both curvatures.
    double bend() const {
        const auto square = [](float part) { return static_cast<double>(part) * static_cast<double>(part); };
        return std::sqrt(square(xx) + square(yy) + square(zz) + 2.0 * (square(xy) + square(xz) + square(yz)));
    }
};

/// The curvature of a triangle between its vertices' normals (Rusinkiewicz 2004, Estimating Curvatures and
/// Their Derivatives on Triangle Meshes), in two directions of its plane.
struct FlatShape {
    dvec3 normal{0.0}, u{0.0}, v{0.0};
    double area = 0.0;  // of the triangle, twice
    double a = 0.0, b = 0.0, c = 0.0;
};

FlatShape flatShapeOf(const storage::SurfaceMesh& mesh, std::uint32_t triangle) {
    const auto& corners = mesh.triangles[triangle];
    const auto at = [&](std::size_t i) { return dvec3(mesh.positions[corners[i % 3]]); };
    const auto normalAt = [&](std::size_t i) { return dvec3(mesh.normals[corners[i % 3]]); };
    FlatShape flat;
    const dvec3 across = glm::cross(at(1) - at(0), at(2) - at(0));
    flat.area = glm::length(across);
    const double side = glm::length(at(1) - at(0));
    if (!(flat.area > 0.0) || !(side > 0.0)) return {};
    flat.normal = across / flat.area;
    flat.u = (at(1) - at(0)) / side;
    flat.v = glm::cross(flat.normal, flat.u);
    double xx = 0.0, xy = 0.0, yy = 0.0;
    dvec3 right(0.0);
    for (std::size_t i = 0; i < 3; ++i) {
        const dvec3 way = at(i + 1) - at(i), turn = normalAt(i + 1) - normalAt(i);
        const double x = glm::dot(way, flat.u), y = glm::dot(way, flat.v);
        const double dx = glm::dot(turn, flat.u), dy = glm::dot(turn, flat.v);
        xx += x * x;
        xy += x * y;
        yy += y * y;
        right += dvec3(x * dx, y * dx + x * dy, y * dy);
    }
    // Of [xx xy 0; xy xx+yy xy; 0 xy yy] (a b c) = right.
    const double determinant = (xx + yy) * (xx * yy - xy * xy);
    if (!(determinant > 1e-12 * xx * yy * (xx + yy))) return {};
    flat.b = (right.y * xx * yy - xy * (right.x * yy + right.z * xx)) / determinant;
    flat.a = (right.x - xy * flat.b) / xx;
    flat.c = (right.z - xy * flat.b) / yy;
    return flat;
}

/// What a triangle's curvature is about another normal: its plane is turned there the shortest way.
void addTurned(const FlatShape& flat, const dvec3& normal, double share, Shape& shape) {
    const double cosine = glm::dot(flat.normal, normal);
    if (cosine <= -0.99) return;
    const auto turned = [&](const dvec3& way) {
        return way - glm::dot(way, normal) / (1.0 + cosine) * (flat.normal + normal);
    };
    const dvec3 u = turned(flat.u), v = turned(flat.v);
    shape.add(u, u, share * flat.a);
    shape.add(u, v, 2.0 * share * flat.b);
    shape.add(v, v, share * flat.c);
}

/// The triangles around each vertex.
class Fans {
  public:
    explicit Fans(const storage::SurfaceMesh& mesh) : begins_(mesh.positions.size() + 1, 0) {
        for (const auto& corners : mesh.triangles) {
            for (const auto corner : corners) ++begins_[corner + 1];
        }
        for (std::size_t i = 1; i < begins_.size(); ++i) begins_[i] += begins_[i - 1];
        triangles_.resize(begins_.back());
        auto next = begins_;
        for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
            for (const auto corner : mesh.triangles[i]) triangles_[next[corner]++] = i;
        }
    }
    template <class Take>
    void each(std::size_t vertex, const Take& take) const {
        for (auto i = begins_[vertex]; i < begins_[vertex + 1]; ++i) take(triangles_[i]);
    }

  private:
    std::vector<std::uint32_t> begins_, triangles_;
};

/// A vertex as the eye sees it.
struct Radial {
    float curvature = 0.0F;  // radial, 1 by unit of layer space: above 0 where it bends away
    float growth = 0.0F;     // of it, by a unit of way towards the eye
    float cosine = 0.0F;     // of the normal and the way to the eye
};

/// Makes the lines of one view.
class SuggestiveFinder {
  public:
    SuggestiveFinder(const MeshSurface& surface, const LineView& view, const std::stop_token& stop)
        : mesh_(surface.mesh()), view_(view), fans_(mesh_), radial_(mesh_.positions.size()) {
        const auto shapes = evened(shapesOf(stop), stop);
        growth_ = leastGrowth * std::pow(usualBend(shapes), 2.0);
        eachVertex(stop, [&](std::size_t i) { look(shapes, i); });
        eachVertex(stop, [&](std::size_t i) { radial_[i].growth = static_cast<float>(growthAt(i)); });
    }

    void find(std::uint32_t triangle, std::vector<EdgeLine>& lines) const {
        const auto& corners = mesh_.triangles[triangle];
        std::array<dvec3, 2> ends{};
        std::array<double, 2> counts{};
        std::size_t count = 0;
        for (std::size_t i = 0; i < 3 && count < 2; ++i)
            count += cross(corners[i], corners[(i + 1) % 3], ends[count], counts[count]) ? 1U : 0U;
        if (count < 2 || (counts[0] <= 0.0 && counts[1] <= 0.0)) return;
        EdgeLine line{.kind = LineKind::suggestive, .vertices = {}, .triangles = {triangle, triangle}};
        const double zero = counts[0] / (counts[0] - counts[1]);
        if (counts[0] < 0.0) ends[0] += zero * (ends[1] - ends[0]);
        if (counts[1] < 0.0) ends[1] = ends[0] + zero * (ends[1] - ends[0]);
        line.ends = ends;
        line.piece = view_.inPicture(view_.toEye(ends[0]), view_.toEye(ends[1]), lineMargin);
        if (!line.piece.empty()) lines.push_back(line);
    }

  private:
    template <class Take>
    void eachVertex(const std::stop_token& stop, const Take& take) const {
        forRangesInTurns(mesh_.positions.size(), atATime, [&](const auto& range) {
            if (isStopped(stop)) return;
            for (auto i = range.begin(); i < range.end(); ++i) take(i);
        });
    }
    std::vector<Shape> shapesOf(const std::stop_token& stop) const {
        std::vector<Shape> shapes(mesh_.positions.size());
        eachVertex(stop, [&](std::size_t i) {
            const dvec3 normal(mesh_.normals[i]);
            double areas = 0.0;
            fans_.each(i, [&](std::uint32_t triangle) {
                const auto flat = flatShapeOf(mesh_, triangle);
                addTurned(flat, normal, flat.area, shapes[i]);
                areas += flat.area;
            });
            if (!(areas > 0.0)) return;
            shapes[i].scale(static_cast<float>(1.0 / areas));
        });
        return shapes;
    }
    /// Each with those at the corners of the triangles around it: what changes from triangle to triangle is
    /// noise.
    std::vector<Shape> evened(const std::vector<Shape>& shapes, const std::stop_token& stop) const {
        std::vector<Shape> even(shapes.size());
        eachVertex(stop, [&](std::size_t i) {
            float count = 0.0F;
            fans_.each(i, [&](std::uint32_t triangle) {
                for (const auto corner : mesh_.triangles[triangle]) even[i].add(shapes[corner]);
                count += 3.0F;
            });
            if (count > 0.0F) even[i].scale(1.0F / count);
        });
        return even;
    }
    /// The median of the vertices' curvatures.
    static double usualBend(const std::vector<Shape>& shapes) {
        if (shapes.empty()) return 0.0;
        constexpr std::size_t most = 50000;
        std::vector<double> bends;
        for (std::size_t i = 0; i < shapes.size(); i += 1 + shapes.size() / most)
            bends.push_back(shapes[i].bend());
        const auto place = bends.begin() + static_cast<std::ptrdiff_t>(bends.size() / 2);
        std::nth_element(bends.begin(), place, bends.end());
        return *place;
    }
    /// The way towards the eye in a vertex's tangent plane, as long as the sine that it is seen at.
    dvec3 wayAt(std::size_t vertex, double& cosine) const {
        const dvec3 toEye = view_.wayToEye(mesh_.positions[vertex]), normal(mesh_.normals[vertex]);
        cosine = glm::dot(toEye, normal);
        return toEye - cosine * normal;
    }
    void look(const std::vector<Shape>& shapes, std::size_t vertex) {
        double cosine = 0.0;
        const dvec3 way = wayAt(vertex, cosine);
        const double square = std::max(glm::dot(way, way), 1e-6);
        radial_[vertex] = {static_cast<float>(shapes[vertex].along(way) / square), 0.0F,
                           static_cast<float>(cosine)};
    }
    /// The slope of the radial curvature in the triangles around a vertex, along the way to the eye.
    double growthAt(std::size_t vertex) const {
        double cosine = 0.0, sum = 0.0, areas = 0.0;
        dvec3 way = wayAt(vertex, cosine);
        const double length = glm::length(way);
        if (!(length > 0.0)) return 0.0;
        way /= length;
        fans_.each(vertex, [&](std::uint32_t triangle) {
            const auto& corners = mesh_.triangles[triangle];
            const dvec3 a(mesh_.positions[corners[0]]), b(mesh_.positions[corners[1]]),
                c(mesh_.positions[corners[2]]);
            const dvec3 across = glm::cross(b - a, c - a);
            const double square = glm::dot(across, across);
            if (!(square > 0.0)) return;
            const auto at = [&](std::size_t i) { return static_cast<double>(radial_[corners[i]].curvature); };
            const dvec3 slope = glm::cross(across, at(0) * (c - b) + at(1) * (a - c) + at(2) * (b - a));
            sum += glm::dot(slope, way) / std::sqrt(square);
            areas += std::sqrt(square);
        });
        return areas > 0.0 ? sum / areas : 0.0;
    }
    /// Where the radial curvature is zero on an edge, and by how much a line there counts: above 0 if it is
    /// drawn. The same from both of its sides.
    bool cross(std::uint32_t one, std::uint32_t other, dvec3& place, double& counts) const {
        if (other < one) std::swap(one, other);
        const double from = static_cast<double>(radial_[one].curvature),
                     to = static_cast<double>(radial_[other].curvature);
        if ((from > 0.0) == (to > 0.0)) return false;
        const double share = from / (from - to);
        const dvec3 a(mesh_.positions[one]), b(mesh_.positions[other]);
        place = a + share * (b - a);
        counts = std::lerp(countsAt(one), countsAt(other), share);
        return true;
    }
    /// Of a side that is seen from inside all signs change.
    double countsAt(std::uint32_t vertex) const {
        const auto& seen = radial_[vertex];
        const double cosine = std::abs(static_cast<double>(seen.cosine));
        const double growth =
            std::copysign(1.0, static_cast<double>(seen.cosine)) * static_cast<double>(seen.growth);
        const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
        const double enough = growth_ > 0.0 ? growth / growth_ - cosine : growth;
        return std::min({enough, (sine - leastSine) / leastSine, (cosine - leastCosine) / leastCosine});
    }

    const storage::SurfaceMesh& mesh_;
    const LineView& view_;
    const Fans fans_;
    std::vector<Radial> radial_;  // of vertices
    double growth_ = 0.0;         // that a line has at least, seen from before
};

}  // namespace

std::vector<EdgeLine> suggestiveLines(const MeshSurface& surface, const LineView& view,
                                      const std::stop_token& stop) {
    const SuggestiveFinder finder(surface, view, stop);
    return inOrder<EdgeLine>(surface.mesh().triangles.size(), stop,
                             [&](std::size_t first, std::size_t last, auto& lines) {
                                 for (std::size_t i = first; i < last; ++i)
                                     finder.find(static_cast<std::uint32_t>(i), lines);
                             });
}

}  // namespace mote::render
