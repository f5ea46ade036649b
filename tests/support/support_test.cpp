// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <glm/common.hpp>
#include <numeric>

#include "tests/support/beams.h"
#include "tests/support/image.h"
#include "tests/support/memory_step.h"
#include "tests/support/temp_dir.h"

namespace mote::test {
namespace {

/// Where a Morton code puts a cell, told bit by bit.
glm::dvec3 place(std::uint64_t morton) {
    glm::dvec3 result(0.0);
    for (int bit = 0; bit < 21; ++bit) {
        for (int axis = 0; axis < 3; ++axis) {
            if (morton >> (3 * bit + axis) & 1U) result[axis] += std::ldexp(1.0, bit);
        }
    }
    return result;
}

class MemoryStepOfABeam : public testing::Test {
  protected:
    static BeamShape shape() {
        BeamShape shape{.core = 3000, .halo = 500, .filaments = 300};
        shape.evenWeights = false;
        return shape;
    }
    std::vector<WeightedPoint> points = beam(shape());
    std::shared_ptr<const MemoryStep> step = MemoryStep::make(points, {.leafCapacity = 20, .maxLevel = 7});
};

TEST_F(MemoryStepOfABeam, EveryPointLiesWhereItWas) {
    const auto nodes = step->nodes();
    const auto leaves = step->leaves();
    std::vector<int> seen(points.size(), 0);
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
        const auto node = leaves.node[leaf];
        const auto positions = step->positions(leaves.pointBegin[leaf], leaves.pointCount[leaf]);
        const auto rows = step->rows(leaves.pointBegin[leaf], leaves.pointCount[leaf]);
        const double edge = std::ldexp(1.0, -nodes.level[node]);
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const glm::dvec3 inCell =
                (glm::dvec3(positions[i].x, positions[i].y, positions[i].z) + 0.5) / 65536.0;
            const glm::dvec3 offset =
                glm::abs(edge * (place(nodes.morton[node]) + inCell) - points[rows[i]].position);
            // Half a step of 16 bits, and double rounding.
            EXPECT_LE(std::max({offset.x, offset.y, offset.z}), edge / 131072.0 + 1e-15);
            ++seen[rows[i]];
        }
    }
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(points.size()));
}

TEST_F(MemoryStepOfABeam, LeavesAscendWithoutGaps) {
    const auto leaves = step->leaves();
    EXPECT_TRUE(std::is_sorted(leaves.density.begin(), leaves.density.end()));
    std::uint64_t next = 0;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        EXPECT_EQ(leaves.pointBegin[i], next);
        EXPECT_GE(leaves.pointCount[i], 1U);
        next += leaves.pointCount[i];
    }
    EXPECT_EQ(next, step->pointCount());
    EXPECT_EQ(step->logDensity().min, leaves.density.front());
    EXPECT_EQ(step->logDensity().max, leaves.density.back());
    EXPECT_LT(step->logDensity().min, step->logDensity().max);
}

TEST_F(MemoryStepOfABeam, NodesTellTheTruthAboutWhatIsBelow) {
    const auto nodes = step->nodes();
    const auto leaves = step->leaves();
    EXPECT_EQ(nodes.count[0], points.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (nodes.childCount[i] == 0) {
            EXPECT_EQ(leaves.node[nodes.firstChild[i]], i);
            EXPECT_TRUE(nodes.count[i] <= 20 || nodes.level[i] == 7);
            continue;
        }
        const auto first = nodes.firstChild[i];
        const auto end = first + nodes.childCount[i];
        EXPECT_GT(first, i);
        EXPECT_EQ(std::accumulate(&nodes.count[first], &nodes.count[first] + nodes.childCount[i], 0ULL),
                  nodes.count[i]);
        EXPECT_EQ(nodes.minDensity[i],
                  *std::min_element(&nodes.minDensity[first], &nodes.minDensity[end - 1] + 1));
        for (auto child = first; child < end; ++child) {
            EXPECT_EQ(nodes.morton[child] >> 3, nodes.morton[i]);
            EXPECT_EQ(nodes.level[child], nodes.level[i] + 1);
            if (child > first) {
                EXPECT_GT(nodes.morton[child], nodes.morton[child - 1]);
            }
        }
    }
}

TEST_F(MemoryStepOfABeam, VolumeHoldsTheWholeWeight) {
    double weight = 0.0;
    for (const auto& point : points) weight += point.weight;
    double inVolume = 0.0;
    for (const float density : step->volume()) inVolume += density;
    const double cells = std::pow(step->volumeSize(), 3.0);
    // Each of 32768 floats is rounded to a relative 2^-24.
    EXPECT_NEAR(inVolume / cells, weight, weight * 1e-7);
    EXPECT_NEAR(step->nodes().density[0], weight, weight * 1e-7);
}

TEST(MemoryStep, NothingAndOnePointAreSteps) {
    const auto nothing = MemoryStep::make({});
    EXPECT_EQ(nothing->pointCount(), 0U);
    EXPECT_EQ(nothing->leaves().size(), 0U);
    EXPECT_EQ(nothing->nodes().count[0], 0U);
    const auto one = MemoryStep::make({{{1.0, 0.0, 0.5}, 2.0}});
    ASSERT_EQ(one->leaves().size(), 1U);
    EXPECT_EQ(one->positions(0, 1)[0].x, 65535);  // the box is closed: its border belongs to the last cell
    EXPECT_EQ(one->leaves().density[0], 2.0F);
}

TEST(MemoryStep, DuplicatesStopAtTheDeepestLevel) {
    const std::vector<WeightedPoint> points(100, {{0.3, 0.3, 0.3}, 1.0});
    const auto step = MemoryStep::make(points, {.leafCapacity = 1, .maxLevel = 6});
    ASSERT_EQ(step->leaves().size(), 1U);
    EXPECT_EQ(step->nodes().level[step->leaves().node[0]], 6);
}

TEST(Image, ComesBackFromItsFile) {
    const TempDir folder;
    Image image{3, 2, {}};
    // Alpha other than 255 as well: pixels must come back as they were, not multiplied by it.
    for (int i = 0; i < 24; ++i) image.pixels.push_back(static_cast<std::uint8_t>(10 * i + 3));
    const auto path = folder / "deeper/image.png";
    const auto status = writePng(image, path);
    ASSERT_TRUE(status.ok()) << status.error().toString();
    const auto again = readPng(path);
    ASSERT_TRUE(again.ok()) << again.error().toString();
    EXPECT_EQ(*again, image);
}

TEST(Image, WhatIsNoPictureIsAnError) {
    const TempDir folder;
    EXPECT_EQ(readPng(folder / "absent.png").error().code, ErrorCode::notFound);
    std::ofstream(folder / "text.png") << "no picture";
    EXPECT_FALSE(readPng(folder / "text.png").ok());
}

TEST(TempDir, IsFreshAndGoesWithAllThatIsInIt) {
    std::filesystem::path path;
    {
        const TempDir one;
        const TempDir other;
        path = one.path();
        EXPECT_NE(one.path(), other.path());
        EXPECT_TRUE(std::filesystem::is_empty(path));
        std::filesystem::create_directories(one / "a/b");
        std::ofstream(one / "a/b/c") << "x";
    }
    EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace mote::test
