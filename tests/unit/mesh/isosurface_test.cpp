// SPDX-License-Identifier: GPL-3.0-or-later
//
// Isosurfaces of volumes whose surfaces are known: where they lie, that they are closed, which side is out.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <random>

#include "preprocess/mesh/isosurface.h"
#include "preprocess/mesh/mesh_job.h"
#include "preprocess/mesh/surface_topology.h"
#include "preprocess/mesh/triangle_mesh.h"
#include "storage/mesh/mesh_file.h"
#include "tests/support/must.h"
#include "tests/support/random.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/mesh/sample_files.h"
#include "tests/unit/particles/quiet_progress.h"

namespace mote::prep {
namespace {

using testing::HasSubstr;
using Field = std::function<double(const glm::dvec3& index)>;

class FieldSource final : public VolumeSource {
  public:
    FieldSource(std::uint32_t side, Field field) : field_(std::move(field)) {
        shape_.nx = side;
        shape_.ny = side + 1;
        shape_.nz = side + 2;
    }
    std::string format() const override { return "field"; }
    const VolumeShape& shape() const override { return shape_; }
    bool sequential() const override { return true; }
    Status read(std::uint32_t z0, std::uint32_t z1, std::span<float> values) override {
        std::size_t i = 0;
        for (auto z = z0; z < z1; ++z) {
            for (std::uint32_t y = 0; y < shape_.ny; ++y)
                for (std::uint32_t x = 0; x < shape_.nx; ++x)
                    values[i++] = static_cast<float>(field_({x, y, z}));
        }
        return success();
    }
    VolumeShape& editShape() { return shape_; }

  private:
    VolumeShape shape_;
    Field field_;
};

Result<TriangleMesh> surfaceOf(FieldSource& source, IsosurfaceOptions options) {
    test::QuietProgress progress;
    if (options.mostTriangles == 0) options.mostTriangles = 1 << 24;
    return isosurface(source, options, progress);
}

glm::dvec3 at(const TriangleMesh& mesh, std::uint32_t vertex) {
    return mesh.positions[vertex];
}

double volumeIn(const TriangleMesh& mesh) {
    double volume = 0.0;
    for (const auto& [a, b, c] : mesh.triangles)
        volume += glm::dot(at(mesh, a), glm::cross(at(mesh, b), at(mesh, c))) / 6.0;
    return volume;
}

/// How often each edge is gone along, by its ends in order.
std::map<std::pair<std::uint32_t, std::uint32_t>, int> edgesOf(const TriangleMesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& triangle : mesh.triangles)
        for (std::size_t i = 0; i < 3; ++i) ++edges[{triangle[i], triangle[(i + 1) % 3]}];
    return edges;
}

bool isClosed(const TriangleMesh& mesh) {
    const auto edges = edgesOf(mesh);
    return std::all_of(edges.begin(), edges.end(), [&](const auto& edge) {
        const auto other = edges.find({edge.first.second, edge.first.first});
        return other != edges.end() && other->second == edge.second;
    });
}

constexpr glm::dvec3 center(11.3, 12.1, 12.7);

double ball(const glm::dvec3& index) {
    return 100.0 - 10.0 * glm::distance(index, center);  // 20 at radius 8
}

TEST(Isosurface, OfABallIsABall) {
    FieldSource source(24, ball);
    const auto mesh = test::must(surfaceOf(source, {.value = 20.0}));
    for (const auto& vertex : mesh.positions)
        EXPECT_NEAR(glm::distance(glm::dvec3(vertex), center), 8.0,
                    0.035);  // as far as the trilinear field is off
    EXPECT_TRUE(isClosed(mesh));
    EXPECT_EQ(mesh.positions.size() + mesh.triangles.size() - edgesOf(mesh).size() / 2, 2U);  // Euler
    EXPECT_NEAR(volumeIn(mesh), 4.0 / 3.0 * 3.14159265 * 512.0, 45.0);  // outwards: above 0
}

/// On a plane the interpolation is exact, and so are the vertices.
TEST(Isosurface, OfASlopeIsAPlane) {
    FieldSource source(12, [](const glm::dvec3& p) { return p.x + 2.0 * p.y - 0.5 * p.z; });
    const auto mesh = surfaceOf(source, {.value = 13.25});
    ASSERT_TRUE(mesh.ok());
    for (const auto& p : mesh->positions) EXPECT_NEAR(p.x + 2.0 * p.y - 0.5 * p.z, 13.25, 1e-5);
    for (const auto& [a, b, c] : mesh->triangles) {
        const auto normal = glm::cross(at(*mesh, b) - at(*mesh, a), at(*mesh, c) - at(*mesh, a));
        EXPECT_LT(glm::dot(normal, glm::dvec3(1.0, 2.0, -0.5)), 0.0);  // towards lower values
    }
}

TEST(Isosurface, LiesInTheWorldAndAMirrorKeepsOutsideOut) {
    for (const double sign : {1.0, -1.0}) {
        FieldSource source(24, ball);
        source.editShape().indexToWorld =
            glm::dmat4(sign * 2.0, 0, 0, 0, 0, 3.0, 0, 0, 0, 0, 1.0, 0, 7, 0, -5, 1);
        const auto mesh = surfaceOf(source, {.value = 20.0});
        ASSERT_TRUE(mesh.ok());
        EXPECT_NEAR(volumeIn(*mesh), 6.0 * 4.0 / 3.0 * 3.14159265 * 512.0, 270.0) << sign;
    }
}

/// Random values: surfaces that touch themselves in every way, still closed but at the volume's sides.
TEST(Isosurface, OfNoiseIsClosedWithin) {
    test::Random random(11);
    std::map<std::tuple<double, double, double>, double> values;
    FieldSource source(9, [&](const glm::dvec3& p) {
        const bool side = p.x == 0 || p.y == 0 || p.z == 0 || p.x == 8 || p.y == 9 || p.z == 10;
        if (side) return 0.0;
        const auto [found, fresh] = values.try_emplace({p.x, p.y, p.z}, 0.0);
        if (fresh) found->second = random.unit();
        return found->second;
    });
    const auto mesh = surfaceOf(source, {.value = 0.5});
    ASSERT_TRUE(mesh.ok());
    EXPECT_GT(mesh->triangles.size(), 500U);
    EXPECT_TRUE(isClosed(*mesh));
}

TEST(Isosurface, SamplesThatAreNoNumbersLieOutside) {
    FieldSource source(8, [](const glm::dvec3& p) {
        return p == glm::dvec3(4.0) ? 1.0
               : p.x < 4.0          ? std::numeric_limits<double>::quiet_NaN()
                                    : std::numeric_limits<double>::infinity();
    });
    const auto mesh = test::must(surfaceOf(source, {.value = 0.5}));
    EXPECT_TRUE(isClosed(mesh));
    EXPECT_EQ(mesh.triangles.size(), 12U);
    for (const auto& p : mesh.positions) EXPECT_LT(glm::distance(glm::dvec3(p), glm::dvec3(4.0)), 1.0);
}

TEST(Isosurface, IsCutByAClipBox) {
    FieldSource source(24, ball);
    const Bounds box{{0.0, 0.0, 0.0}, {30.0, 30.0, center.z}};
    const auto mesh = surfaceOf(source, {.value = 20.0, .clip = box});
    ASSERT_TRUE(mesh.ok());
    for (const auto& p : mesh->positions) EXPECT_LE(p.z, center.z);
    EXPECT_FALSE(isClosed(*mesh));
    const auto gone = surfaceOf(source, {.value = 20.0, .clip = Bounds{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}}});
    EXPECT_THAT(gone.error().message, HasSubstr("clip box"));
}

TEST(Isosurface, SaysWhereThereIsNoneOrTooMuch) {
    FieldSource source(24, ball);
    const auto none = surfaceOf(source, {.value = 1e6});
    EXPECT_EQ(none.error().code, ErrorCode::invalidArgument);
    EXPECT_THAT(none.error().message, HasSubstr("values go from"));
    EXPECT_EQ(surfaceOf(source, {.value = 20.0, .mostTriangles = 100}).error().code,
              ErrorCode::resourceExhausted);
    FieldSource nothing(4, [](const glm::dvec3&) { return std::numeric_limits<double>::quiet_NaN(); });
    EXPECT_THAT(surfaceOf(nothing, {.value = 1.0}).error().message, HasSubstr("no values that are numbers"));
    FieldSource corner(3, [](const glm::dvec3& p) { return p == glm::dvec3(0.0) ? 1.0 : 0.0; });
    EXPECT_THAT(surfaceOf(corner, {.value = 0.5}).error().message, HasSubstr("touches the volume's sides"));
    source.editShape().nz = 1;
    EXPECT_EQ(surfaceOf(source, {.value = 20.0}).error().code, ErrorCode::invalidArgument);
}

TEST(Isosurface, BecomesADatasetByAJob) {
    const test::TempDir folder;
    std::ofstream raw(folder / "ball.raw", std::ios::binary);
    for (int i = 0; i < 16 * 16 * 16; ++i) {
        const glm::dvec3 p(i % 16, i / 16 % 16, i / 256);
        raw.put(static_cast<char>(glm::distance(p, glm::dvec3(7.5)) < 5.0 ? 200 : 0));
    }
    raw.close();
    proto::JobRequest request;
    auto& job = *request.mutable_mesh();
    job.set_input((folder / "ball.raw").string());
    job.set_isovalue(100.0);
    for (int i = 0; i < 3; ++i) job.mutable_source()->add_dimensions(16);
    test::QuietProgress progress;
    const auto made =
        test::must(runMeshJob(request, folder / "ball.raw", folder / "ball.mote", {}, progress));
    EXPECT_EQ(made.request().mesh().isovalue(), 100.0);
    const auto mesh = test::must(storage::readMesh(folder / "ball.mote", made));
    EXPECT_GT(mesh.triangles.size(), 500U);
    job.set_isovalue(200.0);  // at the samples of the ball, where a surface of one sample has no area
    EXPECT_TRUE(runMeshJob(request, folder / "ball.raw", folder / "c.mote", {}, progress).ok());
    const auto small =
        runMeshJob(request, folder / "ball.raw", folder / "b.mote", {.memory = 1000}, progress);
    EXPECT_EQ(small.error().code, ErrorCode::resourceExhausted);
    job.set_isovalue(201.0);
    EXPECT_EQ(runMeshJob(request, folder / "ball.raw", folder / "b.mote", {}, progress).error().where,
              "isovalue");
    EXPECT_FALSE(std::filesystem::exists(folder / "b.mote"));
}

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

namespace mote::test {
namespace {

using storage::MeshEdge;

prep::TriangleMesh weldedMeshOf(const std::string& obj) {
    auto read = readBytes({"mesh.obj", obj});
    EXPECT_TRUE(read.ok());
    return std::move(read->mesh);
}

/// The unit cube, a square a side.
const std::string cube =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

TEST(SurfaceTopology, ACubeHasFlatSidesAndClosedEdges) {
    const auto mesh = prep::makeSurfaceMesh(weldedMeshOf(cube));
    ASSERT_TRUE(storage::checkSurfaceMesh(mesh).ok());
    EXPECT_EQ(mesh.triangles.size(), 12U);
    EXPECT_EQ(mesh.positions.size(), 24U) << "four corners a side, each with the side's own normal";
    EXPECT_EQ(mesh.edges.size(), 18U) << "E = V + F - 2 of the 8 places and 12 triangles";
    for (const auto& edge : mesh.edges) EXPECT_NE(edge.triangles[1], MeshEdge::none);
    for (const auto& [a, b, c] : mesh.triangles) {
        const auto& p = mesh.positions;
        const auto normal = glm::normalize(glm::cross(p[b] - p[a], p[c] - p[a]));
        for (const auto v : {a, b, c}) EXPECT_NEAR(glm::dot(normal, mesh.normals[v]), 1.0F, 1e-6F);
        EXPECT_GT(glm::dot(normal, (p[a] + p[b] + p[c]) / 3.0F - glm::vec3(0.5F)), 0.0F) << "outwards";
    }
}

TEST(SurfaceTopology, BordersAndFansAreEdgesOfOneTriangle) {
    // Three triangles at one edge, as leaves of a book.
    const auto mesh = prep::makeSurfaceMesh(
        weldedMeshOf("v 0 0 0\nv 0 0 1\nv 1 0 0\nv 0 1 0\nv -1 -1 0\nf 1 2 3\nf 1 2 4\nf 1 2 5\n"));
    EXPECT_EQ(mesh.edges.size(), 9U);
    for (const auto& edge : mesh.edges) EXPECT_EQ(edge.triangles[1], MeshEdge::none);
}

TEST(SurfaceTopology, ASmoothSurfaceSharesItsVertices) {
    const auto mesh =
        prep::makeSurfaceMesh(weldedMeshOf("v 0 0 0\nv 1 0 0\nv 1 1 0.1\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"));
    EXPECT_EQ(mesh.positions.size(), 4U);
    EXPECT_EQ(mesh.edges.size(), 5U);
    const auto inner = std::find_if(mesh.edges.begin(), mesh.edges.end(),
                                    [](const auto& edge) { return edge.triangles[1] != MeshEdge::none; });
    ASSERT_NE(inner, mesh.edges.end());
    EXPECT_EQ(inner->triangles, (std::array<std::uint32_t, 2>{0, 1}));
}

TEST(SurfaceTopology, VerticesThatOnlyTouchAreApart) {
    // Two triangles with one corner in common.
    const auto mesh = prep::makeSurfaceMesh(
        weldedMeshOf("v 0 0 0\nv 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nf 1 2 3\nf 1 4 5\n"));
    EXPECT_EQ(mesh.positions.size(), 6U);
}

}  // namespace
}  // namespace mote::test
