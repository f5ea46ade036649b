// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/mesh/triangle_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <random>

namespace mote::prep {
namespace {

constexpr std::uint32_t side = 32;

/// A square of 32 by 32 cells, two triangles each, in random order.
TriangleMesh shuffledSquare() {
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i < (side + 1) * (side + 1); ++i) {
        mesh.positions.emplace_back(i % (side + 1), i / (side + 1), 0.0F);
    }
    for (std::uint32_t i = 0; i < side * side; ++i) {
        const auto v = i % side + (i / side) * (side + 1);
        mesh.triangles.push_back({v, v + 1, v + side + 1});
        mesh.triangles.push_back({v + 1, v + side + 2, v + side + 1});
    }
    std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), std::mt19937(7));
    return mesh;
}

double meanStep(const TriangleMesh& mesh) {
    double sum = 0.0;
    for (std::size_t t = 1; t < mesh.triangles.size(); ++t) {
        sum += glm::distance(mesh.positions[mesh.triangles[t][0]], mesh.positions[mesh.triangles[t - 1][0]]);
    }
    return sum / static_cast<double>(mesh.triangles.size() - 1);
}

TEST(SpatialOrder, WhatIsNearInSpaceIsNearInMemory) {
    const auto shuffled = shuffledSquare();
    auto mesh = shuffled;
    orderInSpace(mesh);
    // Two random places in a square are half its side apart; the steps of a Z curve are 1.7 on average, and
    // a triangle's first corner lies up to a cell off its middle.
    EXPECT_GT(meanStep(shuffled), 0.4 * side);
    EXPECT_LT(meanStep(mesh), 3.0);
}

TEST(SpatialOrder, KeepsEveryTriangleAsItIs) {
    const auto shuffled = shuffledSquare();
    auto mesh = shuffled;
    orderInSpace(mesh);
    EXPECT_EQ(mesh.positions, shuffled.positions);
    EXPECT_TRUE(std::is_permutation(mesh.triangles.begin(), mesh.triangles.end(), shuffled.triangles.begin(),
                                    shuffled.triangles.end()));
}

TEST(SpatialOrder, TrianglesAtOnePlaceStayInOrder) {
    TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{1, 2, 0}, {0, 1, 2}, {2, 1, 0}}};
    const auto before = mesh.triangles;
    orderInSpace(mesh);
    EXPECT_EQ(mesh.triangles, before);
}

}  // namespace
}  // namespace mote::prep
