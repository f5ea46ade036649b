// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/stipple/surface/surface_thinning.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <numeric>

#include "preprocess/stipple/surface/surface_job.h"
#include "server/render/layers/stipple/replay.h"
#include "tests/support/surface_measures.h"
#include "tests/unit/particles/quiet_progress.h"
#include "tests/unit/surface/test_surfaces.h"

namespace mote::test {
namespace {

storage::StippleHierarchy build(const TestSurface& surface, std::uint32_t points, std::uint64_t seed = 1) {
    QuietProgress progress;
    auto start = prep::evenSurfacePoints(*surface.walk, points, seed, 0.3, progress);
    EXPECT_TRUE(start.ok());
    auto made = prep::thinSurface(*surface.walk, *std::move(start), {}, 0.3, progress);
    EXPECT_TRUE(made.ok());
    const auto checked = storage::checkHierarchy(*made);
    EXPECT_TRUE(checked.ok()) << checked.error().toString();
    return *std::move(made);
}

std::vector<glm::vec3> drawnAt(const render::StippleReplay& replay, float level) {
    std::vector<glm::vec3> positions;
    for (const auto& placed : replay.place(replay.select(std::vector<float>(replay.size(), level)))) {
        positions.push_back(placed.position);
    }
    return positions;
}

/// The plane's bars, from the points that replay draws.
void expectEven(const TestSurface& surface, const storage::StippleHierarchy& hierarchy) {
    const render::StippleReplay replay(hierarchy);
    const NearestTriangle nearest(*surface.mesh);
    for (const float level : {1.0F, 0.9F, 0.5F, 0.2F, 0.1F}) {
        const auto set = placeOnSurface(*surface.walk, nearest, drawnAt(replay, level));
        const auto m = measureSurface(*surface.walk, set);
        EXPECT_GT(m.flat, 0.99 * static_cast<double>(m.points)) << level;
        EXPECT_GT(m.rho, 0.65) << level;
        EXPECT_GT(m.nearest, 0.86) << level;
        EXPECT_LT(m.energy, 1.05) << level;
        EXPECT_LT(m.areaCv, 0.085) << level;
    }
}

TEST(SurfaceThinning, OfASphereIsEvenAtEveryLevel) {
    const TestSurface ball(sphere(5));
    expectEven(ball, build(ball, 5000));
}

TEST(SurfaceThinning, OfATorusIsEvenAtEveryLevel) {
    const TestSurface ring(torus());
    expectEven(ring, build(ring, 6000));
}

TEST(SurfaceThinning, MovesStayOnTheSurface) {
    const TestSurface ring(torus());
    const auto hierarchy = build(ring, 1500);
    const NearestTriangle nearest(*ring.mesh);
    // Positions are rounded to floats.
    for (const auto& position : hierarchy.movePosition) EXPECT_LT(nearest.find(position).distance, 1e-6);
}

TEST(SurfaceThinning, ThinSheetsStayApartAndThinOutAlike) {
    const TestSurface sheets(together(square(0.0F), square(0.004F, true)));
    const auto hierarchy = build(sheets, 1000);
    for (std::uint32_t p = 0; p < hierarchy.size(); ++p) {
        for (auto m = hierarchy.movesBegin[p]; m < hierarchy.movesBegin[p + 1]; ++m) {
            EXPECT_EQ(hierarchy.movePosition[m].z, hierarchy.positions[p].z);
            EXPECT_EQ(hierarchy.positions[hierarchy.moveNeighbour[m]].z, hierarchy.positions[p].z);
        }
    }
    const render::StippleReplay replay(hierarchy);
    for (const float level : {1.0F, 0.5F, 0.1F}) {
        const auto drawn = drawnAt(replay, level);
        const auto above = std::count_if(drawn.begin(), drawn.end(), [](auto p) { return p.z > 0.002F; });
        EXPECT_NEAR(static_cast<double>(above) / static_cast<double>(drawn.size()), 0.5, 0.05) << level;
    }
}

TEST(SurfaceThinning, AnOpenPatchIsKeptAndFilled) {
    const TestSurface patch(square(0.0F));
    const auto hierarchy = build(patch, 2000);
    const render::StippleReplay replay(hierarchy);
    const NearestTriangle nearest(*patch.mesh);
    for (const float level : {1.0F, 0.5F, 0.1F}) {
        const auto drawn = drawnAt(replay, level);
        const auto measures = measureSurface(*patch.walk, placeOnSurface(*patch.walk, nearest, drawn));
        EXPECT_EQ(measures.flat, measures.points);
        EXPECT_GT(measures.nearest, 0.86) << level;
        // Cells at the border have other shapes, so they differ more.
        EXPECT_LT(measures.areaCv, 0.12) << level;
        EXPECT_LT(measures.worstArea, 1.6) << level;
    }
}

TEST(SurfaceThinning, AnyNumberOfThreadsMakesTheSame) {
    const TestSurface ring(torus());
    const tbb::global_control more(tbb::global_control::max_allowed_parallelism, 4);
    tbb::task_arena one(1);
    tbb::task_arena four(4);
    const auto a = one.execute([&] { return build(ring, 3000); });
    const auto b = four.execute([&] { return build(ring, 3000); });
    EXPECT_EQ(a.removal, b.removal);
    EXPECT_EQ(a.movePosition, b.movePosition);
    EXPECT_EQ(a.deathArea, b.deathArea);
    const auto c = build(ring, 3000, 2);
    EXPECT_NE(a.positions, c.positions) << "another seed";
}

TEST(SurfaceThinning, FewPointsAndManyPiecesAreSound) {
    const TestSurface ball(sphere(2));
    for (const std::uint32_t points : {1U, 2U, 3U, 4U}) EXPECT_EQ(build(ball, points).size(), points);
    // A hundred leaves with a tenth of a point each, then with ten.
    prep::TriangleMesh leaves;
    for (int i = 0; i < 100; ++i) leaves = together(std::move(leaves), square(static_cast<float>(i)));
    const TestSurface tree(leaves);
    EXPECT_EQ(build(tree, 10).size(), 10U);
    EXPECT_EQ(build(tree, 1000).size(), 1000U);
}

TEST(SurfaceThinning, SelfIntersectionsNeedlesAndFansAreSound) {
    // Two squares through each other, a book of three leaves at one edge, and needles.
    auto mesh =
        together(square(0.0F),
                 gridMesh(4, 4, [](float u, float v) { return glm::vec3(u, 0.5F + 0.01F * v, v - 0.5F); }));
    for (const float angle : {0.5F, 2.0F, 4.0F}) {
        mesh = together(std::move(mesh), gridMesh(1, 1, [=](float u, float v) {
                            return glm::vec3(3.0F + u * std::cos(angle), u * std::sin(angle), v);
                        }));
    }
    mesh = together(std::move(mesh),
                    gridMesh(200, 1, [](float u, float v) { return glm::vec3(5.0F + 0.1F * u, v, 0.0F); }));
    const TestSurface surface(mesh);
    EXPECT_EQ(build(surface, 2000).size(), 2000U);
}

TEST(SurfaceThinning, CancelsAndReports) {
    const TestSurface ball(sphere(4));
    QuietProgress progress;
    auto start = prep::evenSurfacePoints(*ball.walk, 500, 1, 0.3, progress);
    ASSERT_TRUE(start.ok());
    auto copy = *start;
    EXPECT_TRUE(prep::thinSurface(*ball.walk, *std::move(start), {}, 0.3, progress).ok());
    EXPECT_TRUE(std::is_sorted(progress.fractions.begin(), progress.fractions.end()));
    QuietProgress cancelling(3);
    const auto cancelled = prep::thinSurface(*ball.walk, std::move(copy), {}, 0.3, cancelling);
    EXPECT_EQ(cancelled.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace mote::test
