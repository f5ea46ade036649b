// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/stipple/periodic_triangulation.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <random>

#include "preprocess/stipple/stipple_job.h"
#include "tests/support/plane_measures.h"

namespace mote::prep {
namespace {

std::vector<glm::dvec2> whiteNoise(std::size_t count, unsigned seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform;
    std::vector<glm::dvec2> points(count);
    for (auto& point : points) point = {uniform(random), uniform(random)};
    return points;
}

PlaneCell cellOf(PeriodicTriangulation& triangulation, std::uint32_t point) {
    for (int i = 0; i < 8; ++i) {
        if (const auto cell = triangulation.cell(point)) return *cell;
        triangulation.widen();
    }
    ADD_FAILURE() << "the widest margin does not tell the cell of point " << point;
    return {};
}

/// Of the points in `kept`, against cells that are found by clipping.
void expectSameCells(PeriodicTriangulation& triangulation, const std::vector<std::uint32_t>& kept) {
    std::vector<glm::dvec2> positions;
    for (const auto point : kept) positions.push_back(triangulation.position(point));
    const auto expected = test::voronoiCells(positions);
    double sum = 0.0;
    for (std::size_t i = 0; i < kept.size(); ++i) {
        const auto cell = cellOf(triangulation, kept[i]);
        sum += cell.area;
        // Corners are differences of numbers of order 1: errors of some 1e-16 times the ratio of a thin
        // triangle's sides, which is 1e4 in the worst of these sets.
        EXPECT_NEAR(cell.area, expected[i].area, 1e-11) << kept.size() << " points, " << i;
        EXPECT_NEAR(glm::distance(cell.centroid, expected[i].centroid), 0.0, 1e-10);
        EXPECT_NEAR(cell.secondMoment, expected[i].secondMoment, 1e-11);
    }
    EXPECT_NEAR(sum, 1.0, 1e-10);
}

std::vector<std::uint32_t> upTo(std::size_t count) {
    std::vector<std::uint32_t> points(count);
    for (std::uint32_t i = 0; i < count; ++i) points[i] = i;
    return points;
}

TEST(PeriodicTriangulation, CellsAreTheVoronoiCellsOfThePeriodicSquare) {
    for (const std::size_t count : {1U, 2U, 3U, 4U, 5U, 8U, 20U, 60U, 300U, 2000U}) {
        PeriodicTriangulation triangulation(whiteNoise(count, static_cast<unsigned>(count)));
        expectSameCells(triangulation, upTo(count));
    }
}

TEST(PeriodicTriangulation, StayThatWhilePointsMoveAndGo) {
    constexpr std::size_t count = 400;
    PeriodicTriangulation triangulation(stratifiedPoints(count, 5));
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    auto kept = upTo(count);
    while (kept.size() > 1) {
        const double step = 0.4 / std::sqrt(static_cast<double>(kept.size()));
        for (const auto point : kept) {
            if (random() % 4 == 0)
                triangulation.move(point, step * glm::dvec2(normal(random), normal(random)));
        }
        const auto gone = random() % kept.size();
        triangulation.remove(kept[gone]);
        kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(gone));
        if (kept.size() % 20 == 0 || kept.size() < 10) expectSameCells(triangulation, kept);
    }
}

TEST(PeriodicTriangulation, ALatticeIsNoTrouble) {
    // Every four neighbours lie on a circle: the predicates must be exact for this to end well.
    std::vector<glm::dvec2> lattice;
    for (int i = 0; i < 256; ++i) lattice.emplace_back(i % 16 / 16.0, i / 16 / 16.0);
    PeriodicTriangulation triangulation(lattice);
    expectSameCells(triangulation, upTo(lattice.size()));
    for (std::uint32_t i = 0; i < 256; i += 2) triangulation.remove(i);
    std::vector<std::uint32_t> odd;
    for (std::uint32_t i = 1; i < 256; i += 2) odd.push_back(i);
    expectSameCells(triangulation, odd);
}

TEST(PeriodicTriangulation, NobodyMovesOntoAnother) {
    const std::vector<glm::dvec2> points{{0.25, 0.25}, {0.75, 0.25}, {0.5, 0.75}};
    PeriodicTriangulation triangulation(points);
    triangulation.move(0, {0.5, 0.0});
    EXPECT_EQ(triangulation.position(0), glm::dvec2(0.25, 0.25));
    expectSameCells(triangulation, upTo(3));
}

TEST(PeriodicTriangulation, PointsMayWanderFarOff) {
    constexpr std::size_t count = 200;
    PeriodicTriangulation triangulation(stratifiedPoints(count, 6));
    // All of them the same way, in steps of a third of their distance: by two periods in the end.
    for (int step = 0; step < 84; ++step) {
        for (const auto point : upTo(count)) triangulation.move(point, {0.024, 0.0});
    }
    expectSameCells(triangulation, upTo(count));
}

TEST(PeriodicTriangulation, PositionsAreNotWrapped) {
    const std::vector<glm::dvec2> points{{0.75, 0.5}, {0.25, 0.5}};
    PeriodicTriangulation triangulation(points);
    for (int i = 0; i < 6; ++i) triangulation.move(0, {0.0625, 0.0});
    triangulation.widen();
    EXPECT_EQ(triangulation.position(0), glm::dvec2(1.125, 0.5));
    expectSameCells(triangulation, upTo(2));
}

}  // namespace
}  // namespace mote::prep
