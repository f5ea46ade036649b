// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/generated_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

#include "tests/support/random.h"

namespace mote::test {
namespace {

using storage::MeshEdge;
using Place = std::tuple<float, float, float>;

/// Both ends, the lesser first, and whether they were the other way round.
using Side = std::pair<Place, Place>;

struct Use {
    std::uint32_t triangle = 0, corner = 0;
    bool turned = false;
};

Place placeOf(const storage::SurfaceMesh& mesh, std::uint32_t vertex) {
    const auto& at = mesh.positions[vertex];
    return {at.x, at.y, at.z};
}

std::map<Side, std::vector<Use>> sidesOf(const storage::SurfaceMesh& mesh) {
    std::map<Side, std::vector<Use>> sides;
    for (std::uint32_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
        for (std::uint32_t corner = 0; corner < 3; ++corner) {
            auto from = placeOf(mesh, mesh.triangles[triangle][corner]);
            auto to = placeOf(mesh, mesh.triangles[triangle][(corner + 1) % 3]);
            const bool turned = to < from;
            if (turned) std::swap(from, to);
            sides[{from, to}].push_back({triangle, corner, turned});
        }
    }
    return sides;
}

}  // namespace

std::vector<MeshEdge> edgesOf(const storage::SurfaceMesh& mesh) {
    const auto sides = sidesOf(mesh);
    std::vector<MeshEdge> edges;
    for (std::uint32_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
        for (std::uint32_t corner = 0; corner < 3; ++corner) {
            const auto one = mesh.triangles[triangle][corner];
            const auto other = mesh.triangles[triangle][(corner + 1) % 3];
            const auto from = placeOf(mesh, one), to = placeOf(mesh, other);
            const auto& uses = sides.at(to < from ? Side(to, from) : Side(from, to));
            const bool paired = uses.size() == 2 && uses[0].turned != uses[1].turned;
            if (!paired)
                edges.push_back({{one, other}, {triangle, MeshEdge::none}});
            else if (uses[0].triangle == triangle && uses[0].corner == corner)
                edges.push_back({{one, other}, {triangle, uses[1].triangle}});
        }
    }
    return edges;
}

std::shared_ptr<const render::MeshSurface> surfaceOf(storage::SurfaceMesh mesh) {
    mesh.edges = edgesOf(mesh);
    Bounds bounds{mesh.positions.front(), mesh.positions.front()};
    for (const auto& at : mesh.positions) bounds = bounds.united({at, at});
    return std::make_shared<const render::MeshSurface>(std::move(mesh), bounds);
}

namespace {

using storage::SurfaceMesh;

void addVertex(SurfaceMesh& mesh, const glm::dvec3& at, const glm::dvec3& normal) {
    mesh.positions.emplace_back(at);
    mesh.normals.emplace_back(glm::normalize(normal));
}

/// A triangle with corners of its own, all of one normal.
void addFlat(SurfaceMesh& mesh, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const glm::dvec3 area = glm::cross(b - a, c - a);
    const glm::dvec3 normal = glm::length(area) > 0.0 ? area : glm::dvec3(0.0, 0.0, 1.0);
    for (const auto& at : {a, b, c}) addVertex(mesh, at, normal);
    mesh.triangles.push_back({first, first + 1, first + 2});
}

/// Columns and rows of vertices that share their corners, two triangles a square.
template <class Place>
SurfaceMesh gridOf(std::uint32_t columns, std::uint32_t rows, Place place) {
    SurfaceMesh mesh;
    for (std::uint32_t row = 0; row <= rows; ++row) {
        for (std::uint32_t column = 0; column <= columns; ++column) {
            const auto [at, normal] =
                place(static_cast<double>(column) / columns, static_cast<double>(row) / rows);
            addVertex(mesh, at, normal);
        }
    }
    for (std::uint32_t row = 0; row < rows; ++row) {
        for (std::uint32_t column = 0; column < columns; ++column) {
            const std::uint32_t i = row * (columns + 1) + column, above = i + columns + 1;
            mesh.triangles.push_back({i, i + 1, above + 1});
            mesh.triangles.push_back({i, above + 1, above});
        }
    }
    return mesh;
}

using Vertex = std::pair<glm::dvec3, glm::dvec3>;

SurfaceMesh sphere() {
    return gridOf(12, 6, [](double u, double v) {
        const double across = 2.0 * std::numbers::pi * u, up = std::numbers::pi * (v - 0.5);
        const glm::dvec3 at(std::cos(across) * std::cos(up), std::sin(across) * std::cos(up), std::sin(up));
        return Vertex(0.9 * at, at);
    });
}

SurfaceMesh sheet() {
    return gridOf(8, 8, [](double u, double v) {
        const double x = 2.0 * u - 1.0, y = 2.0 * v - 1.0;
        return Vertex({x, y, 0.3 * std::sin(3.0 * x) * y},
                      {-0.9 * std::cos(3.0 * x) * y, -0.3 * std::sin(3.0 * x), 1.0});
    });
}

SurfaceMesh cube() {
    SurfaceMesh mesh;
    for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {-0.75, 0.75}) {
            glm::dvec3 centre(0.0), right(0.0), up(0.0);
            centre[axis] = side;
            right[(axis + 1) % 3] = side;
            up[(axis + 2) % 3] = 0.75;
            addFlat(mesh, centre - right - up, centre + right - up, centre + right + up);
            addFlat(mesh, centre - right - up, centre + right + up, centre - right + up);
        }
    }
    return mesh;
}

glm::dvec3 anywhere(Random& random) {
    const double x = random.between(-1.0, 1.0), y = random.between(-1.0, 1.0);
    return {x, y, random.between(-1.0, 1.0)};
}

/// Triangles anywhere that cross each other, some of them twice in one place.
SurfaceMesh crossing(Random& random) {
    SurfaceMesh mesh;
    for (int i = 0; i < 12; ++i) {
        const auto a = anywhere(random), b = anywhere(random), c = anywhere(random);
        addFlat(mesh, a, b, c);
        if (i % 4 == 0) addFlat(mesh, a, b, c);
    }
    return mesh;
}

SurfaceMesh leaves(Random& random) {
    SurfaceMesh mesh;
    for (int i = 0; i < 60; ++i) {
        const auto at = 0.9 * anywhere(random), right = 0.1 * random.direction();
        const auto up = 0.1 * random.direction();
        addFlat(mesh, at, at + right, at + right + up);
        addFlat(mesh, at, at + right + up, at + up);
    }
    return mesh;
}

/// Long and next to nothing wide, down to nothing.
SurfaceMesh needles(Random& random) {
    SurfaceMesh mesh;
    for (int i = 0; i < 20; ++i) {
        const auto a = anywhere(random), b = anywhere(random);
        addFlat(mesh, a, b, b + (i == 0 ? 0.0 : random.magnitude(-30, -3)) * random.direction());
    }
    return mesh;
}

SurfaceMesh make(const std::string& form, Random& random) {
    if (form == "sphere") return sphere();
    if (form == "sheet") return sheet();
    if (form == "cube") return cube();
    if (form == "crossing") return crossing(random);
    return form == "leaves" ? leaves(random) : needles(random);
}

}  // namespace

std::span<const std::string_view> meshForms() {
    static constexpr std::array<std::string_view, 6> forms{"sphere",   "sheet",  "cube",
                                                           "crossing", "leaves", "needles"};
    return forms;
}

std::shared_ptr<const render::MeshSurface> meshOf(const std::string& form, std::uint32_t number,
                                                  std::uint32_t step) {
    Random random(number + 64 * std::uint64_t{step}, 5);
    auto mesh = make(form, random);
    const double scale = std::array{1.0, 1e-12, 1e12, 1.0}[number % 4];
    const glm::dvec3 aside = number % 4 == 3 ? glm::dvec3(1000.0, -200.0, 5000.0) : glm::dvec3(0.0);
    Bounds bounds;
    for (auto& at : mesh.positions) {
        at = glm::vec3(scale * glm::dvec3(at) + aside);
        const Bounds own{at, at};
        bounds = &at == mesh.positions.data() ? own : bounds.united(own);
    }
    mesh.edges = edgesOf(mesh);
    return std::make_shared<const render::MeshSurface>(std::move(mesh), bounds);
}

}  // namespace mote::test
