// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/stipple/periodic_triangulation.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace mote::prep {
namespace {

/// Which point a vertex is a copy of, and how many periods away from it.
struct Copy {
    std::uint32_t point = 0;
    std::int8_t x = 0;
    std::int8_t y = 0;
};

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<Copy, Kernel>;
using Triangulation =
    CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<VertexBase>>;
using Vertex = Triangulation::Vertex_handle;

// The margin of copies around the square, in mean distances of points. A cell's circles reach less than two
// of them, and points drift by one before copies are chosen anew; cell() says where the circles reach
// further.
constexpr double marginSpacings = 3.5;
// Five by five copies of everything: three by three are enough for the points of the middle one (Dolbilin
// and Huson 1997), and points may drift by a period besides.
constexpr double widestMargin = 2.0;
// Copies are chosen anew when this share of the points is left.
constexpr double renewalShare = 0.6;

/// Rounds to multiples of 2^-40: the sum has no bits below. With the bits of a few periods that is well
/// within 53.
glm::dvec2 onGrid(glm::dvec2 position) {
    constexpr double coarse = 0x1.8p12;
    return {(position.x + coarse) - coarse, (position.y + coarse) - coarse};
}

glm::dvec2 vectorOf(const Kernel::Point_2& point) {
    return {point.x(), point.y()};
}

double cross(glm::dvec2 a, glm::dvec2 b) {
    return a.x * b.y - a.y * b.x;
}

/// The circumcentre of 0, a and b, counterclockwise.
glm::dvec2 circumcentre(glm::dvec2 a, glm::dvec2 b) {
    const double d = 2.0 * cross(a, b);
    const double aa = glm::dot(a, a);
    const double bb = glm::dot(b, b);
    return {(b.y * aa - a.y * bb) / d, (a.x * bb - b.x * aa) / d};
}

/// Adds the triangle 0, a, b; the centroid is still weighted by the area.
void addTriangle(PlaneCell& cell, glm::dvec2 a, glm::dvec2 b) {
    const double area = 0.5 * cross(a, b);
    cell.area += area;
    cell.centroid += area / 3.0 * (a + b);
    cell.secondMoment += area / 6.0 * (glm::dot(a, a) + glm::dot(b, b) + glm::dot(a, b));
}

}  // namespace

struct PeriodicTriangulation::Mesh {
    Triangulation triangulation;
    std::vector<glm::dvec2> position;        // wrapped when copies were last chosen
    std::vector<glm::dvec2> chosenAt;        // where it was then
    std::vector<glm::dvec2> periods;         // that were taken off it by then
    std::vector<Vertex> vertex;              // null for a point that was removed
    std::vector<std::uint32_t> copiesBegin;  // into copies, by point
    std::vector<Vertex> copies;
    std::size_t left = 0;
    std::size_t renewAt = 0;
    double margin = 0.0;  // of copies around the square
    double drift = 0.0;   // how far a point may go from there
    double safe = 0.0;    // the part of the margin that no point can have entered or left unseen

    std::vector<Triangulation::Edge> edges;  // to be looked at by restore

    void renew(double newMargin);
    bool displace(Vertex moved, const Kernel::Point_2& to);
    bool starIsOriented(Vertex moved) const;
    void restore(Vertex moved);
    void insertPoints();
    void insertCopies();
    double spacing() const { return 1.0 / std::sqrt(static_cast<double>(std::max<std::size_t>(left, 1))); }
};

void PeriodicTriangulation::Mesh::renew(double newMargin) {
    renewAt = static_cast<std::size_t>(renewalShare * static_cast<double>(left));
    margin = std::min(newMargin, widestMargin);
    drift = spacing();
    safe = margin - drift;
    triangulation.clear();
    insertPoints();
    insertCopies();
    chosenAt = position;
}

void PeriodicTriangulation::Mesh::insertPoints() {
    Triangulation::Face_handle hint;
    for (std::uint32_t i = 0; i < position.size(); ++i) {
        if (vertex[i] == Vertex()) continue;
        const glm::dvec2 away(std::floor(position[i].x), std::floor(position[i].y));
        position[i] -= away;
        periods[i] += away;
        vertex[i] = triangulation.insert({position[i].x, position[i].y}, hint);
        vertex[i]->info() = {i, 0, 0};
        hint = vertex[i]->face();
    }
}

void PeriodicTriangulation::Mesh::insertCopies() {
    std::vector<std::vector<Vertex>> made(25);
    copiesBegin.assign(position.size() + 1, 0);
    // Shift by shift, so that each copy lies near the one before it, as the points do.
    for (std::int8_t y = -2; y <= 2; ++y) {
        for (std::int8_t x = -2; x <= 2; ++x) {
            if (x == 0 && y == 0) continue;
            Triangulation::Face_handle hint;
            for (std::uint32_t i = 0; i < position.size(); ++i) {
                const auto at = position[i] + glm::dvec2(x, y);
                if (vertex[i] == Vertex() || std::min(at.x, at.y) < -margin ||
                    std::max(at.x, at.y) > 1.0 + margin) {
                    continue;
                }
                const auto copy = triangulation.insert({at.x, at.y}, hint);
                copy->info() = {i, x, y};
                hint = copy->face();
                made[static_cast<std::size_t>(5 * (y + 2) + x + 2)].push_back(copy);
                ++copiesBegin[i + 1];
            }
        }
    }
    for (std::size_t i = 0; i < position.size(); ++i) copiesBegin[i + 1] += copiesBegin[i];
    copies.resize(copiesBegin.back());
    auto next = copiesBegin;
    for (const auto& shift : made) {
        for (const auto copy : shift) copies[next[copy->info().point]++] = copy;
    }
}

/// CGAL's move_if_no_collision, but for its lists, whose memory takes as long as the geometry; what is no
/// small displacement is left to it. False where another vertex lies there.
bool PeriodicTriangulation::Mesh::displace(Vertex moved, const Kernel::Point_2& to) {
    const auto from = moved->point();
    moved->set_point(to);
    if (starIsOriented(moved)) {
        restore(moved);
        return true;
    }
    moved->set_point(from);
    return triangulation.move_if_no_collision(moved, to) == moved;
}

bool PeriodicTriangulation::Mesh::starIsOriented(Vertex moved) const {
    auto face = triangulation.incident_faces(moved);
    const auto first = face;
    do {
        if (triangulation.is_infinite(face) ||
            CGAL::orientation(face->vertex(0)->point(), face->vertex(1)->point(), face->vertex(2)->point()) !=
                CGAL::COUNTERCLOCKWISE) {
            return false;
        }
    } while (++face != first);
    return true;
}

/// Flips edges until the triangulation is Delaunay again, from the star of the one vertex that moved.
void PeriodicTriangulation::Mesh::restore(Vertex moved) {
    auto face = triangulation.incident_faces(moved);
    const auto first = face;
    edges.clear();
    do {
        const int i = face->index(moved);
        edges.emplace_back(face, i);
        edges.emplace_back(face, Triangulation::cw(i));
    } while (++face != first);
    while (!edges.empty()) {
        const auto [at, i] = edges.back();
        edges.pop_back();
        const auto across = at->neighbor(i);
        const int mirror = triangulation.tds().mirror_index(at, i);
        const auto opposite = across->vertex(mirror);
        if (triangulation.is_infinite(at->vertex(i)) || triangulation.is_infinite(opposite) ||
            triangulation.side_of_oriented_circle(at, opposite->point(), true) != CGAL::ON_POSITIVE_SIDE) {
            continue;
        }
        triangulation.tds().flip(at, i);
        for (const auto& [other, j] : {std::pair(at, i), std::pair(across, mirror)}) {
            edges.emplace_back(other, j);
            edges.emplace_back(other, Triangulation::cw(j));
        }
    }
}

PeriodicTriangulation::PeriodicTriangulation(std::span<const glm::dvec2> positions)
    : mesh_(std::make_unique<Mesh>()) {
    mesh_->left = positions.size();
    mesh_->position.reserve(positions.size());
    for (const auto& position : positions) mesh_->position.push_back(onGrid(position));
    mesh_->periods.resize(positions.size());
    // Anything but null, until they are inserted.
    mesh_->vertex.assign(positions.size(), mesh_->triangulation.infinite_vertex());
    mesh_->renew(marginSpacings * mesh_->spacing());
}

PeriodicTriangulation::PeriodicTriangulation(PeriodicTriangulation&&) noexcept = default;
PeriodicTriangulation::~PeriodicTriangulation() = default;

glm::dvec2 PeriodicTriangulation::position(std::uint32_t point) const {
    return mesh_->position[point] + mesh_->periods[point];
}

void PeriodicTriangulation::widen() {
    mesh_->renew(2.0 * mesh_->margin);
}

std::optional<PlaneCell> PeriodicTriangulation::cell(std::uint32_t point) const {
    const auto vertex = mesh_->vertex[point];
    const auto at = mesh_->position[point];
    auto face = mesh_->triangulation.incident_faces(vertex);
    const auto first = face;
    PlaneCell cell;
    std::optional<glm::dvec2> start;
    glm::dvec2 last{};
    double radius2 = 0.0;
    do {
        if (mesh_->triangulation.is_infinite(face)) return std::nullopt;
        const int i = face->index(vertex);
        const auto corner = circumcentre(vectorOf(face->vertex(face->ccw(i))->point()) - at,
                                         vectorOf(face->vertex(face->cw(i))->point()) - at);
        if (start) addTriangle(cell, last, corner);
        if (!start) start = corner;
        last = corner;
        radius2 = std::max(radius2, glm::dot(corner, corner));
    } while (++face != first);
    addTriangle(cell, last, *start);
    cell.centroid /= cell.area;
    // All that the cell depends on lies within its circles, which pass through the point.
    const double reach = 2.0 * std::sqrt(radius2);
    const bool known =
        std::min(at.x, at.y) - reach > -mesh_->safe && std::max(at.x, at.y) + reach < 1.0 + mesh_->safe;
    if (!known && mesh_->margin < widestMargin) return std::nullopt;
    return cell;
}

void PeriodicTriangulation::addNeighbours(std::uint32_t point, std::vector<std::uint32_t>& neighbours) const {
    auto vertex = mesh_->triangulation.incident_vertices(mesh_->vertex[point]);
    const auto first = vertex;
    do {
        neighbours.push_back(vertex->info().point);
    } while (++vertex != first);
}

void PeriodicTriangulation::move(std::uint32_t point, glm::dvec2 by) {
    const auto to = onGrid(mesh_->position[point] + by);
    const auto vertex = mesh_->vertex[point];
    if (!mesh_->displace(vertex, {to.x, to.y})) return;
    mesh_->position[point] = to;
    for (auto i = mesh_->copiesBegin[point]; i < mesh_->copiesBegin[point + 1]; ++i) {
        const auto copy = mesh_->copies[i];
        mesh_->displace(copy, {to.x + copy->info().x, to.y + copy->info().y});
    }
    if (glm::distance(to, mesh_->chosenAt[point]) > mesh_->drift) mesh_->renew(mesh_->margin);
}

void PeriodicTriangulation::remove(std::uint32_t point) {
    mesh_->triangulation.remove(mesh_->vertex[point]);
    mesh_->vertex[point] = Vertex();
    for (auto i = mesh_->copiesBegin[point]; i < mesh_->copiesBegin[point + 1]; ++i) {
        mesh_->triangulation.remove(mesh_->copies[i]);
    }
    if (--mesh_->left < mesh_->renewAt)
        mesh_->renew(marginSpacings * mesh_->spacing() / std::sqrt(renewalShare));
}

}  // namespace mote::prep
