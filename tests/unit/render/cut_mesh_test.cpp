// SPDX-License-Identifier: GPL-3.0-or-later
//
// Meshes that are cut: what is left lies on the right side, what both sides leave is the whole, and edges are
// as they are found in the plainest way.
#include "server/render/layers/mesh/cut_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "tests/support/generated_mesh.h"
#include "tests/support/random.h"

namespace mote::render {
namespace {

double areaOf(const storage::SurfaceMesh& mesh) {
    double area = 0.0;
    for (const auto& [a, b, c] : mesh.triangles) {
        const glm::dvec3 at(mesh.positions[a]);
        area += 0.5 * glm::length(
                          glm::cross(glm::dvec3(mesh.positions[b]) - at, glm::dvec3(mesh.positions[c]) - at));
    }
    return area;
}

HalfSpace anySide(test::Random& random, const Bounds& bounds) {
    const glm::dvec3 normal = random.direction();
    const double x = random.unit(), y = random.unit(), z = random.unit();
    return {normal, glm::dot(normal, bounds.min + bounds.size() * glm::dvec3(x, y, z))};
}

TEST(CutMesh, BothSidesTogetherAreTheWhole) {
    test::Random random(7, 0);
    for (const auto form : test::meshForms()) {
        const auto surface = test::meshOf(std::string(form), 1, 0);
        const auto& mesh = surface->mesh();
        const double whole = areaOf(mesh), scale = glm::length(surface->bounds().size());
        for (int i = 0; i < 8; ++i) {
            const HalfSpace side = anySide(random, surface->bounds());
            const auto front = cutMesh(mesh, {side}), back = cutMesh(mesh, {{-side.normal, -side.distance}});
            EXPECT_NEAR(areaOf(front) + areaOf(back), whole, 1e-5 * whole) << form;
            for (const auto& place : front.positions)
                EXPECT_GE(side.within(glm::dvec3(place)), -1e-6 * scale) << form;
        }
    }
}

TEST(CutMesh, IsAMeshAsDatasetsHaveThem) {
    test::Random random(8, 0);
    for (const auto form : test::meshForms()) {
        const auto surface = test::meshOf(std::string(form), 2, 0);
        for (int i = 0; i < 4; ++i) {
            const HalfSpaces clips{anySide(random, surface->bounds()), anySide(random, surface->bounds())};
            const auto mesh = cutMesh(surface->mesh(), clips);
            EXPECT_TRUE(storage::checkSurfaceMesh(mesh).ok()) << form;
            // Of the others triangles also meet that go one way round along an edge.
            if (form == "cube" || form == "sheet") {
                EXPECT_EQ(mesh.edges, test::edgesOf(mesh)) << form;
            }
            // A closed surface is open along the cut alone.
            for (const auto& edge : mesh.edges) {
                if (edge.triangles[1] != storage::MeshEdge::none) continue;
                double nearest = 1e300;
                const glm::dvec3 middle = 0.5 * (glm::dvec3(mesh.positions[edge.vertices[0]]) +
                                                 glm::dvec3(mesh.positions[edge.vertices[1]]));
                for (const auto& side : clips) nearest = std::min(nearest, std::abs(side.within(middle)));
                const bool closed = form == "cube";
                if (closed) {
                    EXPECT_LT(nearest, 1e-5 * glm::length(surface->bounds().size())) << form;
                }
            }
        }
    }
}

TEST(CutMesh, NothingMayBeLeft) {
    const auto surface = test::meshOf(std::string(test::meshForms()[0]), 1, 0);
    const auto mesh = cutMesh(surface->mesh(), {{{1.0, 0.0, 0.0}, 1e6}});
    EXPECT_TRUE(mesh.triangles.empty() && mesh.positions.empty() && mesh.edges.empty());
}

}  // namespace
}  // namespace mote::render
