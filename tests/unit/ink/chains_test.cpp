// SPDX-License-Identifier: GPL-3.0-or-later
//
// Visible pieces become long lines: nothing is lost or bent, and steps in depth are those of the scene.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "server/render/layers/ink/mesh_lines.h"
#include "tests/support/generated_mesh.h"
#include "tests/unit/ink/ink_views.h"

namespace mote::render {
namespace {

struct Segment {
    glm::dvec2 from, to;

    double length() const { return glm::distance(from, to); }
    double distance(const glm::dvec2& place) const {
        const glm::dvec2 way = to - from;
        const double square = glm::dot(way, way);
        const double share = square > 0.0 ? std::clamp(glm::dot(place - from, way) / square, 0.0, 1.0) : 0.0;
        return glm::distance(place, from + share * way);
    }
};

std::vector<Segment> segmentsOf(const MeshSurface& surface, const LineView& view,
                                const std::vector<EdgeLine>& pieces) {
    std::vector<Segment> segments;
    for (const auto& piece : pieces) {
        const auto from = view.toEye(surface.mesh().positions[piece.vertices[0]]);
        const auto to = view.toEye(surface.mesh().positions[piece.vertices[1]]);
        segments.push_back({view.onScreen(from + piece.piece.begin * (to - from)),
                            view.onScreen(from + piece.piece.end * (to - from))});
    }
    return segments;
}

std::vector<Segment> segmentsOf(const std::vector<InkLine>& lines) {
    std::vector<Segment> segments;
    for (const auto& line : lines) {
        for (std::size_t i = 0; i + 1 < line.points.size(); ++i)
            segments.push_back({line.points[i].at, line.points[i + 1].at});
    }
    return segments;
}

double lengthOf(const std::vector<Segment>& segments) {
    double length = 0.0;
    for (const auto& segment : segments) length += segment.length();
    return length;
}

/// How far the places of some segments are at most from all others.
double farthest(const std::vector<Segment>& some, const std::vector<Segment>& others) {
    double most = 0.0;
    for (const auto& segment : some) {
        for (int i = 0; i <= 4; ++i) {
            const glm::dvec2 place = segment.from + 0.25 * i * (segment.to - segment.from);
            double least = HUGE_VAL;
            for (const auto& other : others) least = std::min(least, other.distance(place));
            most = std::max(most, least);
        }
    }
    return most;
}

void expectNoSharpTurn(const InkLine& line) {
    for (std::size_t i = 1; i + 1 < line.points.size(); ++i) {
        const glm::dvec2 in = line.points[i].at - line.points[i - 1].at;
        const glm::dvec2 out = line.points[i + 1].at - line.points[i].at;
        // Points off by the tolerance turn short segments.
        if (glm::length(in) < 2.0 || glm::length(out) < 2.0) continue;
        EXPECT_GE(glm::dot(glm::normalize(in), glm::normalize(out)), 0.2 - 0.15);
    }
}

TEST(Chains, LoseNothingAndStayWithinTheirTolerance) {
    test::Random random(3);
    double pieceLength = 0.0, chainLength = 0.0;
    for (const auto form : test::meshForms()) {
        for (std::uint32_t number = 0; number < 4; ++number) {
            const auto surface = test::surfaceOf(test::meshOf(std::string(form), number, 0)->mesh());
            for (int i = 0; i < 4; ++i) {
                const auto transform = test::anyTransform(random);
                const auto camera = test::anyCamera(random, surface->bounds().transformed(transform));
                const LineView view(test::planOf(camera, 96, 72), transform);
                const auto pieces =
                    visible(*surface, view, linesOf(*surface, view, 60.0, {}), {.sampling = 0.5}, {});
                const auto lines = chained(*surface, view, pieces, 1.0, {});
                const auto before = segmentsOf(*surface, view, pieces), after = segmentsOf(lines);
                EXPECT_NEAR(lengthOf(after), lengthOf(before), 0.03 * lengthOf(before) + 1.0)
                    << form << ' ' << number << ' ' << i;
                pieceLength += lengthOf(before);
                chainLength += lengthOf(after);
                EXPECT_LE(farthest(before, after), 0.13) << form << ' ' << number << ' ' << i;
                EXPECT_LE(farthest(after, before), 0.13) << form << ' ' << number << ' ' << i;
                for (const auto& line : lines) {
                    ASSERT_GE(line.points.size(), 2U);
                    expectNoSharpTurn(line);
                    for (const auto& point : line.points) EXPECT_TRUE(point.step >= 0.0 && point.step <= 1.0);
                }
            }
        }
    }
    EXPECT_GT(pieceLength, 10000.0);
    EXPECT_NEAR(chainLength / pieceLength, 1.0, 0.01);
}

/// A disc of triangles around its middle, at a height, or a square where it has four corners.
void addDisc(storage::SurfaceMesh& mesh, std::uint32_t corners, double radius, double z) {
    const auto middle = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.emplace_back(0.0F, 0.0F, z);
    for (std::uint32_t i = 0; i < corners; ++i) {
        const double angle = 2.0 * std::numbers::pi * (i + 0.5) / corners;
        mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
        mesh.triangles.push_back({middle, middle + 1 + i, middle + 1 + (i + 1) % corners});
    }
    mesh.normals.assign(mesh.positions.size(), glm::vec3(0.0F, 0.0F, 1.0F));
}

/// Seen from above: a unit is 10 pixels.
FramePlan fromAbove() {
    Camera camera;
    camera.eye = {0.0, 0.0, 50.0};
    camera.orthographicHeight = 10.0;
    return test::planOf(camera, 100, 100);
}

std::vector<InkLine> chainsOf(storage::SurfaceMesh mesh, double extent) {
    const auto surface = test::surfaceOf(std::move(mesh));
    const LineView view(fromAbove(), glm::dmat4(1.0));
    return chained(*surface, view,
                   visible(*surface, view, linesOf(*surface, view, 60.0, {}), {.sampling = 0.5}, {}), extent,
                   {});
}

TEST(Chains, AClosedLineComesOnce) {
    for (const std::uint32_t corners : {5U, 6U, 24U, 100U}) {
        storage::SurfaceMesh mesh;
        addDisc(mesh, corners, 3.0, 0.0);
        const auto lines = chainsOf(mesh, 1.0);
        ASSERT_EQ(lines.size(), 1U) << corners;
        const auto& points = lines[0].points;
        EXPECT_LT(glm::distance(points.front().at, points.back().at), 1e-9);
        const double around = 2.0 * corners * 30.0 * std::sin(std::numbers::pi / corners);
        EXPECT_NEAR(lengthOf(segmentsOf(lines)), around, 0.01 * around);
        for (const auto& point : points) {
            EXPECT_EQ(point.step, 1.0) << "beside nothing";
            EXPECT_NEAR(point.depth, 50.0, 1e-9);
        }
    }
}

TEST(Chains, EndAtCorners) {
    storage::SurfaceMesh mesh;
    addDisc(mesh, 4, 3.0, 0.0);
    const auto lines = chainsOf(mesh, 1.0);
    ASSERT_EQ(lines.size(), 4U);
    for (const auto& line : lines) EXPECT_EQ(line.points.size(), 2U);
}

TEST(Chains, AStepIsHowMuchFartherAWallIs) {
    for (const double off : {0.5, 2.0, 8.0, 20.0}) {
        storage::SurfaceMesh mesh;
        addDisc(mesh, 4, 2.0, 0.0);
        addDisc(mesh, 4, 4.0, -off);
        int inner = 0, outer = 0;
        for (const auto& line : chainsOf(mesh, 10.0)) {
            const bool ofWall = line.points[0].depth > 50.0 + 0.5 * off;
            (ofWall ? outer : inner)++;
            for (const auto& point : line.points)
                EXPECT_NEAR(point.step, ofWall ? 1.0 : std::min(1.0, off / 10.0), 1e-6);
        }
        EXPECT_EQ(inner, 4);
        EXPECT_EQ(outer, 4);
    }
}

}  // namespace
}  // namespace mote::render
