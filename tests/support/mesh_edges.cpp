// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/mesh_edges.h"

#include <map>
#include <tuple>
#include <utility>

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

}  // namespace mote::test
