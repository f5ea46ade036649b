// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>

#include "preprocess/mesh/triangle_mesh.h"
#include "preprocess/stipple/stipple_job.h"
#include "preprocess/stipple/surface/surface_cell.h"
#include "preprocess/stipple/surface/surface_job.h"
#include "preprocess/stipple/surface/surface_thinning.h"
#include "preprocess/stipple/surface/walk_mesh.h"
#include "server/render/layers/stipple/replay.h"
#include "server/render/layers/stipple/surface_dots.h"
#include "storage/manifest.h"
#include "storage/mesh/mesh_file.h"
#include "storage/stipple/stipple_hierarchy.h"
#include "storage/verify.h"
#include "tests/support/surface_measures.h"
#include "tests/support/temp_dir.h"
#include "tests/support/view_text.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::test {
namespace {

// Small surfaces for tests, as a job would have read them. Values.

/// A mesh and what the builder makes of it; the walk refers to the mesh.
struct TestSurface {
    explicit TestSurface(const prep::TriangleMesh& raw) {
        prep::MeshCounts counts;
        const auto welded = prep::weldMesh(raw, counts);
        mesh = std::make_unique<storage::SurfaceMesh>(prep::makeSurfaceMesh(welded));
        walk = std::make_unique<prep::WalkMesh>(*mesh, prep::findNeighbours(welded.triangles));
    }

    std::unique_ptr<storage::SurfaceMesh> mesh;
    std::unique_ptr<prep::WalkMesh> walk;
};

/// A grid of columns x rows squares, two triangles each, `place` of (0..1, 0..1).
prep::TriangleMesh gridMesh(int columns, int rows, const std::function<glm::vec3(float, float)>& place);

prep::TriangleMesh gridMesh(int columns, int rows, const std::function<glm::vec3(float, float)>& place) {
    prep::TriangleMesh mesh;
    for (int y = 0; y <= rows; ++y) {
        for (int x = 0; x <= columns; ++x) {
            mesh.positions.push_back(place(static_cast<float>(x) / static_cast<float>(columns),
                                           static_cast<float>(y) / static_cast<float>(rows)));
        }
    }
    const auto at = [&](int x, int y) { return static_cast<std::uint32_t>(y * (columns + 1) + x); };
    for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < columns; ++x) {
            mesh.triangles.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
            mesh.triangles.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
        }
    }
    return mesh;
}

/// Both meshes side by side.
prep::TriangleMesh together(prep::TriangleMesh first, const prep::TriangleMesh& second) {
    const auto begin = static_cast<std::uint32_t>(first.positions.size());
    first.positions.insert(first.positions.end(), second.positions.begin(), second.positions.end());
    for (const auto& [a, b, c] : second.triangles) {
        first.triangles.push_back({a + begin, b + begin, c + begin});
    }
    return first;
}

/// Radius 1, an octahedron whose triangles were divided into four `times` times.
prep::TriangleMesh sphere(int times) {
    prep::TriangleMesh mesh;
    mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int i = 0; i < times; ++i) {
        prep::TriangleMesh finer;
        for (const auto& triangle : mesh.triangles) {
            std::array<glm::vec3, 6> p;
            for (std::size_t k = 0; k < 3; ++k) p[k] = mesh.positions[triangle[k]];
            for (std::size_t k = 0; k < 3; ++k) p[3 + k] = glm::normalize(p[k] + p[(k + 1) % 3]);
            const auto begin = static_cast<std::uint32_t>(finer.positions.size());
            finer.positions.insert(finer.positions.end(), p.begin(), p.end());
            for (const auto& [a, b, c] : {prep::Triangle{0, 3, 5}, prep::Triangle{3, 1, 4},
                                          prep::Triangle{5, 4, 2}, prep::Triangle{3, 4, 5}}) {
                finer.triangles.push_back({begin + a, begin + b, begin + c});
            }
        }
        mesh = std::move(finer);
    }
    return mesh;
}

/// Radii 1 and 0.4.
prep::TriangleMesh torus() {
    return gridMesh(96, 48, [](float u, float v) {
        // The ends of the grid are one place: the angle is taken round so that they are so to the last bit.
        const float a = 6.2831853F * (u < 1.0F ? u : 0.0F);
        const float b = 6.2831853F * (v < 1.0F ? v : 0.0F);
        const float r = 1.0F + 0.4F * std::cos(b);
        return glm::vec3(r * std::cos(a), r * std::sin(a), 0.4F * std::sin(b));
    });
}

/// The unit square at a height, seen from above or, turned, from below.
prep::TriangleMesh square(float height, bool turned = false) {
    return gridMesh(
        8, 8, [=](float u, float v) { return turned ? glm::vec3(v, u, height) : glm::vec3(u, v, height); });
}

storage::StippleHierarchy build(const TestSurface& surface, std::uint32_t points, std::uint64_t seed = 1) {
    QuietProgress progress;
    auto start = prep::evenSurfacePoints(*surface.walk, points, seed, 0.3, progress);
    EXPECT_TRUE(start.ok());
    auto made = prep::thinSurface(*surface.walk, *std::move(start), prep::thinningOptions({}), 0.3, progress);
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
    EXPECT_TRUE(
        prep::thinSurface(*ball.walk, *std::move(start), prep::thinningOptions({}), 0.3, progress).ok());
    EXPECT_TRUE(std::is_sorted(progress.fractions.begin(), progress.fractions.end()));
    QuietProgress cancelling(3);
    const auto cancelled =
        prep::thinSurface(*ball.walk, std::move(copy), prep::thinningOptions({}), 0.3, cancelling);
    EXPECT_EQ(cancelled.error().code, ErrorCode::cancelled);
}

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

// The stipple job on a mesh, from the file to the dataset.

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

class SurfaceJob : public testing::Test {
  protected:
    void SetUp() override {
        std::ofstream file(input_);
        const auto mesh = sphere(3);
        for (const auto& p : mesh.positions) file << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
        for (const auto& [a, b, c] : mesh.triangles) {
            file << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << '\n';
        }
        request_.mutable_stipple()->set_mesh(input_.string());
        request_.mutable_stipple()->set_points(400);
        request_.mutable_stipple()->set_seed(7);
    }
    Result<proto::Manifest> run(const std::string& name, prep::Progress& progress,
                                const prep::JobResources& options = {}) {
        return prep::runSurfaceJob(request_, input_, folder_ / name, options, progress);
    }
    std::string bytesOf(const fs::path& name) const {
        std::ifstream file(folder_ / name, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    long entries() const {
        return std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator());
    }

    TempDir folder_;
    fs::path input_ = folder_ / "ball.obj";
    proto::JobRequest request_;
    QuietProgress progress_;
};

TEST_F(SurfaceJob, MakesAHierarchyBesideItsMesh) {
    const auto made = run("ball.mote", progress_);
    ASSERT_TRUE(made.ok()) << made.error().toString();
    EXPECT_TRUE(std::is_sorted(progress_.fractions.begin(), progress_.fractions.end()));
    EXPECT_DOUBLE_EQ(progress_.fractions.back(), 1.0);
    const auto manifest = storage::readManifest(folder_ / "ball.mote");
    ASSERT_TRUE(manifest.ok()) << manifest.error().toString();
    EXPECT_EQ(manifest->kind(), "stipple");
    EXPECT_EQ(manifest->stipple().domain(), proto::StippleManifest::SURFACE);
    EXPECT_EQ(manifest->request().stipple().mesh(), "ball.obj");
    EXPECT_DOUBLE_EQ(manifest->stipple().area(), manifest->mesh().area());
    const auto mesh = storage::readMesh(folder_ / "ball.mote", *manifest);
    ASSERT_TRUE(mesh.ok()) << mesh.error().toString();
    EXPECT_EQ(mesh->triangles.size(), 512U);
    const auto hierarchy = storage::readHierarchy(folder_ / "ball.mote", *manifest);
    ASSERT_TRUE(hierarchy.ok()) << hierarchy.error().toString();
    EXPECT_EQ(hierarchy->size(), 400U);
    EXPECT_GT(manifest->stipple().locked(), 0U) << "the last ones on a sphere cannot see it flat";
    EXPECT_LT(manifest->stipple().locked(), 200U);
    EXPECT_THAT(storage::verifyDataset(folder_ / "ball.mote"), IsEmpty());
}

TEST_F(SurfaceJob, TheSameSeedMakesTheSameBytes) {
    ASSERT_TRUE(run("a.mote", progress_, {1, 0}).ok());
    QuietProgress again;
    ASSERT_TRUE(run("b.mote", again, {3, 0}).ok());
    for (const auto* file : {"hierarchy.h5", "hierarchy.digest", "mesh.h5", "manifest.json"}) {
        EXPECT_EQ(bytesOf(fs::path("a.mote") / file), bytesOf(fs::path("b.mote") / file)) << file;
    }
}

TEST_F(SurfaceJob, MorePointsThanMemoryIsSaidAtOnce) {
    request_.mutable_stipple()->set_points(1000000);
    const auto made = run("a.mote", progress_, {0, 64 << 20});
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().code, ErrorCode::resourceExhausted);
    EXPECT_THAT(made.error().toString(), HasSubstr("1000000 points"));
    EXPECT_EQ(entries(), 1);
}

TEST_F(SurfaceJob, FailuresLeaveNothing) {
    QuietProgress cancelling(5);
    EXPECT_EQ(run("a.mote", cancelling).error().code, ErrorCode::cancelled);
    std::ofstream(input_) << "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n";
    const auto flat = run("a.mote", progress_);
    ASSERT_FALSE(flat.ok());
    EXPECT_THAT(flat.error().toString(), HasSubstr("1 triangles without area"));
    EXPECT_EQ(entries(), 1);
}

// Dots of a real hierarchy on a surface that turns: those that stay hardly ever jump.

render::StippleSurface stippledTorus(const TestSurface& torus, std::uint32_t points) {
    QuietProgress progress;
    auto start = prep::evenSurfacePoints(*torus.walk, points, 1, 0.3, progress);
    EXPECT_TRUE(start.ok());
    const auto made =
        prep::thinSurface(*torus.walk, *std::move(start), prep::thinningOptions({}), 0.3, progress);
    EXPECT_TRUE(made.ok());
    const Bounds bounds{{-1.4, -1.4, -1.4}, {1.4, 1.4, 1.4}};
    return {render::StippleReplay(*made), render::SurfaceRays(torus.mesh->positions, torus.mesh->triangles),
            bounds, torus.walk->area()};
}

struct Place {
    glm::vec3 position;  ///< on the surface
    double spacing;      ///< of neighbours at the wanted density
};

std::map<std::uint32_t, Place> placesAt(const render::StippleSurface& surface, double degrees) {
    const double angle = degrees * std::numbers::pi / 180.0;
    View view = viewOf(
        "{'width': 400, 'height': 400, 'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0], "
        "'orthographicHeight': 3}, 'layers': [{'stipple': {'spacingPixels': 7}}]}");
    view.camera.eye = {4.0 * std::sin(angle), 2.0, 4.0 * std::cos(angle)};
    const auto& style = *view.layers[0].stipple();
    const render::SurfaceDots layer(surface, style, view, glm::dmat4(1.0));
    const render::SurfaceView screen(view, glm::dmat4(1.0));
    const render::WantedDensity wanted(surface, style, screen);
    std::map<std::uint32_t, Place> places;
    for (const auto& shown : layer.seen(layer.chosen())) {
        const double share = std::min<double>(wanted.at(shown.point).share, 1.0);
        const double spacing = std::sqrt(2.0 / (std::numbers::sqrt3 * share * surface.density()));
        places.emplace(shown.point, Place{shown.position, spacing});
    }
    return places;
}

TEST(TurnedSurface, DotsThatStaySeldomMoveFurtherThanTheJitterAllows) {
    const TestSurface torus(test::torus());
    const auto surface = stippledTorus(torus, 12000);
    std::size_t stayed = 0, beyond = 0, dots = 0;
    auto before = placesAt(surface, 0.0);
    for (int degrees = 1; degrees <= 30; ++degrees) {
        auto now = placesAt(surface, degrees);
        for (const auto& [point, place] : now) {
            const auto found = before.find(point);
            if (found == before.end()) continue;
            ++stayed;
            // Full jitter moves a dot by half of the distance of neighbours.
            const double way = glm::distance(place.position, found->second.position) / place.spacing;
            if (way > 0.5) ++beyond;
        }
        dots += now.size();
        before = std::move(now);
    }
    // Where a neighbour that went early comes back, all moves after its removal are undone at once: on the
    // teapot one dot in 4000.
    EXPECT_LE(beyond, stayed / 1000);
    EXPECT_GT(static_cast<double>(stayed), 0.9 * static_cast<double>(dots));
}

prep::SurfacePoint placeOn(const TestSurface& surface, const glm::vec3& near) {
    const auto found = NearestTriangle(*surface.mesh).find(near);
    return {found.position, found.triangle};
}

TEST(WalkMesh, OnAPlaneItGoesStraight) {
    const TestSurface plane(square(0.0F));
    const auto from = placeOn(plane, {0.11F, 0.23F, 0.0F});
    const glm::dvec3 step(0.7, 0.61, 0.0);
    const auto to = plane.walk->walk(from, step);
    EXPECT_LT(glm::distance(to.position, from.position + step), 1e-12);
    EXPECT_LT(NearestTriangle(*plane.mesh).find(glm::vec3(to.position)).distance, 1e-7);
}

TEST(WalkMesh, ItEndsAtABorder) {
    const TestSurface plane(square(0.0F));
    const auto to = plane.walk->walk(placeOn(plane, {0.5F, 0.3F, 0.0F}), {4.0, 0.0, 0.0});
    EXPECT_NEAR(to.position.x, 1.0, 1e-12);
    EXPECT_NEAR(to.position.y, 0.3, 1e-7);
}

TEST(WalkMesh, AroundAPrismItKeepsItsLength) {
    // A developable surface: walking once around a prism of 36 sides at a right angle to its axis leads back.
    constexpr int sides = 36;
    const TestSurface prism(gridMesh(sides, 4, [](float u, float v) {
        const double a = 2.0 * std::numbers::pi * (u < 1.0F ? u : 0.0F);
        return glm::vec3(std::cos(a), std::sin(a), v);
    }));
    const auto from = placeOn(prism, {1.0F, 0.01F, 0.4F});
    const double around = sides * 2.0 * std::sin(std::numbers::pi / sides);
    const auto to = prism.walk->walk(from, {0.0, around, 0.0});
    // Corners are rounded to floats, so each side is off by some 1e-7.
    EXPECT_LT(glm::distance(to.position, from.position), 1e-5);
}

TEST(WalkMesh, OnASphereItFollowsAGreatCircle) {
    const TestSurface ball(sphere(6));
    const auto from = placeOn(ball, {1.0F, 0.02F, 0.03F});
    const auto to = ball.walk->walk(from, {0.0, 0.0, 1.0});
    // An angle of 1, from one of 0.03. Triangles of edge 0.025 lie up to 1e-4 below the sphere, and
    // straightest geodesics turn a little at each edge.
    EXPECT_NEAR(std::asin(to.position.z / glm::length(to.position)), 1.03, 0.01);
}

TEST(WalkMesh, NormalsAreSmoothButAtCreases) {
    const TestSurface ball(sphere(5));
    for (const auto& place : {glm::vec3(0.3F, 0.8F, 0.5F), glm::vec3(-0.6F, 0.1F, -0.7F)}) {
        const auto point = placeOn(ball, place);
        EXPECT_GT(glm::dot(ball.walk->normalAt(point), glm::normalize(point.position)), 0.9999);
    }
}

}  // namespace
}  // namespace mote::test
