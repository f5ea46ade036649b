// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/stipple/surface/surface_cell.h"

#include <gtest/gtest.h>

#include <cmath>

#include "preprocess/stipple/surface/surface_job.h"
#include "tests/unit/particles/quiet_progress.h"
#include "tests/unit/surface/test_surfaces.h"

namespace mote::test {
namespace {

std::vector<prep::SurfaceCell> cellsOf(const TestSurface& surface, const prep::PointSet& set) {
    const prep::SurfaceCells cells(*surface.walk, set);
    prep::CellScratch scratch(surface.walk->triangles(), set.points.size());
    std::vector<prep::SurfaceCell> found(set.points.size());
    for (std::uint32_t i = 0; i < found.size(); ++i) {
        cells.find(i, prep::SurfaceCells::none, scratch, found[i]);
    }
    return found;
}

double areaOf(const std::vector<prep::SurfaceCell>& cells) {
    double sum = 0.0;
    for (const auto& cell : cells) sum += cell.area;
    return sum;
}

TEST(SurfaceCells, OfRandomPointsCoverAFlatPatchExactly) {
    const TestSurface patch(square(0.0F));
    auto set = prep::scatterPoints(*patch.walk, 500, 3);
    // Random points leave gaps in which a cell reaches further than is looked, 1.6 spacings. One step closes
    // them.
    prep::relaxOnce(*patch.walk, set, 1.0);
    const auto cells = cellsOf(patch, set);
    EXPECT_NEAR(areaOf(cells), 1.0, 1e-9) << "in one plane and cut at the borders, they leave nothing out";
    std::size_t atBorder = 0;
    for (std::uint32_t i = 0; i < cells.size(); ++i) {
        EXPECT_TRUE(cells[i].flat);
        atBorder += cells[i].atBorder ? 1 : 0;
        for (const auto neighbour : cells[i].neighbours) {
            const auto& back = cells[neighbour].neighbours;
            EXPECT_NE(std::find(back.begin(), back.end(), i), back.end())
                << "neighbours are so to each other";
        }
    }
    // 4 sides of some sqrt(500) points.
    EXPECT_GT(atBorder, 60U);
    EXPECT_LT(atBorder, 130U);
}

TEST(SurfaceCells, CoverACurvedSurface) {
    // Cells of 2000 points on the sphere reach over angles of 0.05: the tangent plane is off by their
    // squares.
    const TestSurface ball(sphere(5));
    EXPECT_NEAR(areaOf(cellsOf(ball, prep::scatterPoints(*ball.walk, 2000, 1))) / ball.walk->area(), 1.0,
                0.01);
    const TestSurface ring(torus());
    EXPECT_NEAR(areaOf(cellsOf(ring, prep::scatterPoints(*ring.walk, 4000, 1))) / ring.walk->area(), 1.0,
                0.01);
}

TEST(SurfaceCells, OfSheetsThatLieCloseDoNotSeeEachOther) {
    // A tenth of a spacing apart, once looking the same way and once, as a closed thin plate, away from each
    // other.
    for (const bool turned : {false, true}) {
        const TestSurface sheets(together(square(0.0F), square(0.005F, turned)));
        const auto set = prep::scatterPoints(*sheets.walk, 1000, 5);
        const auto cells = cellsOf(sheets, set);
        EXPECT_NEAR(areaOf(cells), 2.0, 1e-9);
        for (std::uint32_t i = 0; i < cells.size(); ++i) {
            for (const auto neighbour : cells[i].neighbours) {
                EXPECT_EQ(set.points[i].position.z, set.points[neighbour].position.z);
            }
        }
    }
}

TEST(SurfaceCells, AreNotFlatWhereTheSurfaceTurnsAway) {
    // Twelve points on a sphere: neighbours are 63 degrees apart.
    const TestSurface ball(sphere(4));
    QuietProgress progress;
    const auto set = prep::evenSurfacePoints(*ball.walk, 12, 1, 1.0, progress);
    ASSERT_TRUE(set.ok());
    for (const auto& cell : cellsOf(ball, *set)) EXPECT_FALSE(cell.flat);
}

TEST(SurfaceStart, SpreadsEvenly) {
    const TestSurface ball(sphere(5));
    QuietProgress progress;
    const auto set = prep::evenSurfacePoints(*ball.walk, 3000, 1, 1.0, progress);
    ASSERT_TRUE(set.ok());
    const auto cells = cellsOf(ball, *set);
    const double mean = areaOf(cells) / 3000.0;
    double squares = 0.0;
    for (const auto& cell : cells) squares += (cell.area - mean) * (cell.area - mean) / 3000.0;
    // The plane's bar.
    EXPECT_LT(std::sqrt(squares) / mean, 0.085);
    QuietProgress cancelling(0);
    EXPECT_EQ(prep::evenSurfacePoints(*ball.walk, 3000, 1, 1.0, cancelling).error().code,
              ErrorCode::cancelled);
}

}  // namespace
}  // namespace mote::test
