// SPDX-License-Identifier: GPL-3.0-or-later
//
// Rays against meshes: every ray through a closed sheet meets it once, also along its edges and through its
// corners, at any magnification; and the tree leaves nothing out.
#include "server/render/layers/mesh/mesh_rays.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "tests/support/generated_mesh.h"
#include "tests/support/random.h"

namespace mote::render {
namespace {

using Rays = std::array<MeshRay, MeshRays::packet>;
using Meetings = std::array<MeshMeeting, MeshRays::packet>;

MeshRay rayAlong(const MeshRays& mesh, const glm::dvec3& from, const glm::dvec3& direction) {
    MeshRay ray{from, direction, 0.0, 1e30};
    ray.clip(mesh.box());
    return ray;
}

/// A flat grid of unit squares from (0, 0) to (side, side), each cut along its diagonal.
storage::SurfaceMesh flatGrid(std::uint32_t side) {
    storage::SurfaceMesh mesh;
    for (std::uint32_t y = 0; y <= side; ++y) {
        for (std::uint32_t x = 0; x <= side; ++x) {
            mesh.positions.emplace_back(x, y, 0.0F);
            mesh.normals.emplace_back(0.0F, 0.0F, 1.0F);
        }
    }
    for (std::uint32_t y = 0; y < side; ++y) {
        for (std::uint32_t x = 0; x < side; ++x) {
            const std::uint32_t i = y * (side + 1) + x, above = i + side + 1;
            mesh.triangles.push_back({i, i + 1, above + 1});
            mesh.triangles.push_back({i, above + 1, above});
        }
    }
    return mesh;
}

TEST(MeshRays, ARayThroughAnEdgeOrACornerMeetsOneTriangle) {
    const auto grid = flatGrid(4);
    const MeshRays mesh(grid, {glm::dvec3(0.0), {4.0, 4.0, 0.0}});
    std::vector<MeshMeeting> met;
    for (int y = 1; y < 16; ++y) {
        for (int x = 1; x < 16; ++x) {
            const glm::dvec3 at(0.25 * x, 0.25 * y, 0.0);
            for (const glm::dvec3 way : {glm::dvec3(0.0, 0.0, -1.0), {0.0, 0.0, 1.0}, {0.5, -0.25, -1.0}}) {
                mesh.all(rayAlong(mesh, at - 3.0 * way, way), met);
                ASSERT_EQ(met.size(), 1U) << x << ' ' << y;
                EXPECT_EQ(met[0].at, 3.0);
            }
        }
    }
}

TEST(MeshRays, WithinASmallestPartOfATriangleItTellsPlacesApart) {
    const auto grid = flatGrid(1);
    const MeshRays mesh(grid, {glm::dvec3(0.0), {1.0, 1.0, 0.0}});
    std::vector<MeshMeeting> met;
    for (const double off : {1e-12, -1e-12}) {
        mesh.all(rayAlong(mesh, {0.5 + off, 0.5, 1.0}, {0.0, 0.0, -1.0}), met);
        ASSERT_EQ(met.size(), 1U);
        EXPECT_EQ(met[0].triangle, off > 0.0 ? 0U : 1U);
    }
    mesh.all(rayAlong(mesh, {1.0 + 1e-12, 0.5, 1.0}, {0.0, 0.0, -1.0}), met);
    EXPECT_TRUE(met.empty());
}

/// Every triangle tried, in order.
std::vector<std::uint32_t> met(const storage::SurfaceMesh& mesh, const MeshRay& ray) {
    std::vector<std::pair<double, std::uint32_t>> all;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        if (const auto one = meet(mesh, i, ray)) all.emplace_back(one->at, i);
    }
    std::sort(all.begin(), all.end());
    std::vector<std::uint32_t> triangles;
    triangles.reserve(all.size());
    for (const auto& [at, triangle] : all) triangles.push_back(triangle);
    return triangles;
}

/// Of every form and size, from near and far: the tree leaves no triangle out, and a packet's rays meet first
/// what each meets first alone.
TEST(MeshRays, TheTreeLeavesNothingOut) {
    test::Random random(5);
    std::size_t meetings = 0;
    for (const auto form : test::meshForms()) {
        for (std::uint32_t number = 0; number < 4; ++number) {
            const auto surface = test::meshOf(std::string(form), number, 0);
            const auto& mesh = surface->rays();
            const double size = glm::length(surface->bounds().size());
            for (int i = 0; i < 20; ++i) {
                Rays rays;
                const auto center = surface->bounds().center();
                const auto from = center + random.oneOf({0.1, 2.0, 1e3, 1e6}) * size * random.direction();
                for (auto& ray : rays)
                    ray = rayAlong(mesh, from, center + 0.4 * size * random.direction() - from);
                Meetings first;
                mesh.first(rays, first);
                for (std::size_t k = 0; k < rays.size(); ++k) {
                    const auto wanted = met(surface->mesh(), rays[k]);
                    std::vector<MeshMeeting> all;
                    mesh.all(rays[k], all);
                    ASSERT_EQ(all.size(), wanted.size()) << form << ' ' << number;
                    for (std::size_t m = 0; m < all.size(); ++m) EXPECT_EQ(all[m].triangle, wanted[m]);
                    EXPECT_EQ(first[k].triangle, wanted.empty() ? MeshMeeting::none : wanted[0]);
                    EXPECT_EQ(mesh.blocked(rays[k]), !wanted.empty());
                    meetings += wanted.size();
                }
            }
        }
    }
    EXPECT_GT(meetings, 2000U);
}

/// As long as an Embree device of one thread lives, TBB has one thread for everything.
TEST(MeshRays, LeaveAllThreadsToOthers) {
    const auto threads = [] {
        return tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    };
    const auto before = threads();
    const auto grid = flatGrid(1);
    const MeshRays mesh(grid, {glm::dvec3(0.0), {1.0, 1.0, 0.0}});
    EXPECT_EQ(threads(), before);
}

TEST(MeshRays, AnEmptyRayMeetsNothing) {
    const auto grid = flatGrid(1);
    const MeshRays mesh(grid, {glm::dvec3(0.0), {1.0, 1.0, 0.0}});
    std::vector<MeshMeeting> met(3);
    mesh.all({}, met);
    EXPECT_TRUE(met.empty());
    EXPECT_FALSE(mesh.blocked({}));
    EXPECT_TRUE(rayAlong(mesh, {5.0, 5.0, 1.0}, {0.0, 0.0, -1.0}).empty());
}

}  // namespace
}  // namespace mote::render
