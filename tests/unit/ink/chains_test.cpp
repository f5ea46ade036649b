// SPDX-License-Identifier: GPL-3.0-or-later
//
// Visible pieces become long lines: nothing is lost or bent, and steps in depth are those of the scene.
#include <gtest/gtest.h>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <numbers>

#include "server/render/layers/ink/mesh_lines.h"
#include "server/render/layers/ink/mesh_modalities.h"
#include "storage/mesh/triangle_intersection.h"
#include "tests/support/generated_mesh.h"
#include "tests/support/random.h"
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

// Lines where surfaces go through each other: of two spheres, held to the
// circle in which they meet.

constexpr std::uint32_t viewWidth = 240, viewHeight = 200;
constexpr double creaseFrom = 60.0, noCreases = 180.0;  // degrees
constexpr std::uint32_t sphereColumns = 72, sphereRows = 36;

/// Their radius is 1.
struct Spheres {
    glm::dvec3 one{0.0}, other{0.9, 0.3, 0.5};

    glm::dvec3 middle() const { return 0.5 * (one + other); }
    glm::dvec3 axis() const { return glm::normalize(other - one); }
    double radius() const { return std::sqrt(1.0 - 0.25 * glm::dot(other - one, other - one)); }
    glm::dvec3 onCircle(double turn) const {
        const auto across = glm::normalize(glm::cross(axis(), glm::dvec3(0.0, 0.0, 1.0)));
        return middle() + radius() * (std::cos(turn) * across + std::sin(turn) * glm::cross(axis(), across));
    }
    /// Above 0 where nothing of them is in front of a place of the circle, below
    /// where something is.
    double facing(const glm::dvec3& at, const glm::dvec3& towards) const {
        return std::min(glm::dot(at - one, towards), glm::dot(at - other, towards));
    }
};

void addSphere(storage::SurfaceMesh& mesh, const glm::dvec3& centre) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (std::uint32_t row = 0; row <= sphereRows; ++row) {
        for (std::uint32_t column = 0; column < sphereColumns; ++column) {
            const double up = glm::pi<double>() * row / sphereRows,
                         around = glm::two_pi<double>() * column / sphereColumns;
            const bool pole = row == 0 || row == sphereRows;
            const double wide = pole ? 0.0 : std::sin(up);
            const glm::dvec3 at(wide * std::cos(around), wide * std::sin(around), std::cos(up));
            mesh.positions.emplace_back(centre + at);
            mesh.normals.emplace_back(at);
        }
    }
    for (std::uint32_t row = 0; row < sphereRows; ++row) {
        for (std::uint32_t column = 0; column < sphereColumns; ++column) {
            const std::uint32_t next = (column + 1) % sphereColumns, a = first + row * sphereColumns,
                                b = a + sphereColumns;
            if (row + 1 < sphereRows) mesh.triangles.push_back({a + column, b + column, b + next});
            if (row > 0) mesh.triangles.push_back({a + column, b + next, a + next});
        }
    }
}

std::shared_ptr<const MeshSurface> madeOf(const Spheres& spheres) {
    storage::SurfaceMesh mesh;
    addSphere(mesh, spheres.one);
    const auto half = static_cast<std::uint32_t>(mesh.triangles.size());
    addSphere(mesh, spheres.other);
    const storage::TriangleIntersections rule(mesh);
    for (std::uint32_t i = 0; i < half; ++i) {
        for (std::uint32_t k = half; k < mesh.triangles.size(); ++k) {
            if (rule.between(i, k)) mesh.intersections.push_back({i, k});
        }
    }
    return test::surfaceOf(std::move(mesh));
}

/// Made once: all pairs of triangles are tried.
std::shared_ptr<const MeshSurface> surfaceOfTwo() {
    static const auto made = madeOf(Spheres());
    return made;
}

bool isIntersection(const MeshSurface& surface, const EdgeLine& line) {
    return line.vertices[0] >= surface.mesh().positions.size();
}

double distanceTo(const glm::dvec3& from, const glm::dvec3& to, const glm::dvec3& place) {
    const glm::dvec3 way = to - from;
    const double share = std::clamp(glm::dot(place - from, way) / glm::dot(way, way), 0.0, 1.0);
    return glm::distance(from + share * way, place);
}

/// Of spheres of so many columns the polygon lies up to 1 - cos(pi / 36) =
/// 0.0038 within.
constexpr double offCircle = 0.01;

struct CountedPlaces {
    std::size_t seen = 0, hidden = 0;
};

/// What is drawn of the circle in a view, and what is not.
void holdCircle(const Spheres& spheres, const MeshSurface& surface, const Camera& camera, bool likely,
                CountedPlaces& total) {
    const auto plan = test::planOf(camera, viewWidth, viewHeight);
    const LineView view(plan, glm::dmat4(1.0));
    const auto pictures = modalitiesOf(surface, glm::dmat4(1.0), test::usualInk(), plan, {});
    const auto edges = linesOf(surface, view, creaseFrom, {});
    const auto pieces = visible(surface, view, edges,
                                {.sampling = 0.35,
                                 .likely = likely ? &pictures.triangle : nullptr,
                                 .farthest = likely ? &pictures.farthest : nullptr},
                                {});
    for (int i = 0; i < 360; ++i) {
        const auto at = spheres.onCircle(glm::radians(static_cast<double>(i)));
        const glm::dvec3 towards =
            glm::normalize(camera.perspective() ? camera.eye - at : camera.eye - camera.target);
        const double facing = spheres.facing(at, towards);
        if (std::abs(facing) < 0.15) continue;  // a polygon's side is seen a little sooner or later
        const auto place = view.toEye(at);
        const bool drawn = std::any_of(pieces.begin(), pieces.end(), [&](const EdgeLine& piece) {
            const auto [from, to] = partOf(endsOf(surface, piece, view), piece.piece);
            return isIntersection(surface, piece) && distanceTo(from, to, place) < 2.0 * offCircle;
        });
        EXPECT_EQ(drawn, facing > 0.0) << i << " degrees, facing " << facing;
        ++(facing > 0.0 ? total.seen : total.hidden);
    }
}

TEST(Intersections, OfTwoSpheresAreTheirCircleWhereItIsSeen) {
    test::Random random(7);
    const Spheres spheres;
    const auto surface = surfaceOfTwo();
    CountedPlaces total;
    for (int i = 0; i < 12; ++i) {
        Camera camera;
        camera.target = spheres.middle();
        camera.eye = camera.target + random.oneOf({3.0, 6.0, 40.0}) * random.direction();
        camera.up = random.direction();
        camera.fovYDegrees = 2.0 * glm::degrees(std::atan(1.7 / glm::distance(camera.eye, camera.target)));
        if (i % 3 == 0) camera.orthographicHeight = 3.4;
        holdCircle(spheres, *surface, camera, i % 2 == 0, total);
    }
    EXPECT_GT(total.seen, 1000U);
    EXPECT_GT(total.hidden, 300U);
}

/// From afar, where some of the circle is seen.
Camera aslant(const Spheres& spheres) {
    Camera camera;
    camera.target = spheres.middle();
    camera.eye = camera.target + 15.0 * (spheres.onCircle(0.3) - spheres.middle()) + 9.0 * spheres.axis();
    camera.fovYDegrees = 12.0;
    return camera;
}

TEST(Intersections, LieOnTheCircleAndFollowOneAnother) {
    const Spheres spheres;
    const auto surface = surfaceOfTwo();
    const std::size_t count = surface->mesh().intersections.size();
    ASSERT_GT(count, std::size_t{sphereColumns});
    for (std::uint32_t i = 0; i < 2 * count; ++i) {
        const auto at = surface->place(static_cast<std::uint32_t>(surface->mesh().positions.size()) + i);
        EXPECT_NEAR(glm::dot(at - spheres.middle(), spheres.axis()), 0.0, offCircle);
        EXPECT_NEAR(glm::distance(at, spheres.middle()), spheres.radius(), offCircle);
    }
    const auto camera = aslant(spheres);
    const LineView view(test::planOf(camera, viewWidth, viewHeight), glm::dmat4(1.0));
    auto lines = linesOf(*surface, view, creaseFrom, {});
    std::erase_if(lines, [&](const EdgeLine& line) { return !isIntersection(*surface, line); });
    EXPECT_EQ(lines.size(), count);
    EXPECT_EQ(chained(*surface, view, lines, 1.0, {}).size(), 1U) << "seen or not, a closed line";
    const auto seen = visible(*surface, view, lines, {.sampling = 0.35}, {});
    EXPECT_EQ(chained(*surface, view, seen, 1.0, {}).size(), 1U) << "the tessellation breaks it nowhere";
}

TEST(Intersections, AreDrawnWhereCreasesAre) {
    const Spheres spheres;
    const auto surface = surfaceOfTwo();
    auto plan = test::planOf(aslant(spheres), viewWidth, viewHeight);
    const LineView view(plan, glm::dmat4(1.0));
    for (const auto& line : linesOf(*surface, view, noCreases, {}))
        EXPECT_FALSE(isIntersection(*surface, line));
    plan.exact = false;
    const auto pictures = modalitiesOf(*surface, glm::dmat4(1.0), test::usualInk(), plan, {});
    auto lines = linesOf(*surface, view, creaseFrom, {});
    std::erase_if(lines, [&](const EdgeLine& line) { return !isIntersection(*surface, line); });
    double length = 0.0;
    for (const auto& line : quickLines(*surface, view, lines, pictures.modalities, {}))
        length += glm::distance(line.points.front().at, line.points.back().at);
    EXPECT_GT(length, 50.0) << "pixels, in a picture in motion";
}

/// A mesh's list may name triangles that do not cut each other.
TEST(Intersections, PairsThatAreNoneDrawNothing) {
    auto mesh = surfaceOfTwo()->mesh();
    const auto sound = mesh.intersections.size();
    mesh.intersections.push_back({0, 1});
    mesh.intersections.push_back({5, 5});
    EXPECT_EQ(test::surfaceOf(std::move(mesh))->mesh().intersections.size(), sound);
}

}  // namespace
}  // namespace mote::render
