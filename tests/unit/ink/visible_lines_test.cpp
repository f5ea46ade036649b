// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which edges are lines and what is seen of them, compared with a plain trial of all triangles in eye space,
// place by place.
#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "server/render/ink/choose_lines.h"
#include "server/render/ink/complexity.h"
#include "server/render/ink/tone_grid.h"
#include "server/render/layers/ink/mesh_lines.h"
#include "server/render/layers/ink/mesh_modalities.h"
#include "tests/support/generated_mesh.h"
#include "tests/support/random.h"
#include "tests/unit/ink/ink_views.h"

namespace mote::render {
namespace {

constexpr std::uint32_t width = 96, height = 72;
constexpr double every = 0.3;    // pixels between places that are tried
constexpr double crease = 60.0;  // degrees
constexpr auto none = storage::MeshEdge::none;

enum class Drawn { no, yes, undecided };

/// The plain trial.
class Oracle {
  public:
    Oracle(const storage::SurfaceMesh& mesh, const FramePlan& plan, const glm::dmat4& transform)
        : mesh_(mesh),
          perspective_(plan.camera.perspective()),
          nearest_(perspective_ ? 1e-3 * glm::distance(plan.camera.eye, plan.camera.target) : -HUGE_VAL),
          scale_(0.5 * height / plan.camera.halfHeight()) {
        const glm::dmat4 toEye = plan.camera.worldToEye() * transform;
        turn_ = glm::dmat3(toEye);
        glm::dvec3 least(HUGE_VAL), most(-HUGE_VAL);
        for (const auto& at : mesh.positions) {
            eye_.emplace_back(toEye * glm::dvec4(glm::dvec3(at), 1.0));
            least = glm::min(least, eye_.back());
            most = glm::max(most, eye_.back());
        }
        size_ = glm::distance(least, most);
    }

    Drawn drawn(const storage::MeshEdge& edge, LineKind& kind) const {
        kind = LineKind::border;
        if (edge.triangles[0] == none || edge.triangles[1] == none) return Drawn::yes;
        const double one = side(edge.triangles[0]), other = side(edge.triangles[1]);
        if (std::min(std::abs(one), std::abs(other)) < 1e-9) return Drawn::undecided;
        kind = LineKind::silhouette;
        if ((one > 0.0) != (other > 0.0)) return Drawn::yes;
        kind = LineKind::crease;
        const double turn = glm::degrees(
            std::acos(std::clamp(glm::dot(normal(edge.triangles[0]), normal(edge.triangles[1])), -1.0, 1.0)));
        if (std::abs(turn - crease) < 1e-5) return Drawn::undecided;
        return turn > crease ? Drawn::yes : Drawn::no;
    }

    /// Calls take(share of the edge, whether it is seen) for places of an edge in the picture.
    template <class Take>
    void places(const storage::MeshEdge& edge, const Take& take) const {
        glm::dvec3 a = eye_[edge.vertices[0]], b = eye_[edge.vertices[1]];
        double begin = 0.0, end = 1.0;
        if (-a.z < nearest_ && -b.z < nearest_) return;
        if (-a.z < nearest_) begin = (nearest_ + a.z) / (a.z - b.z);
        if (-b.z < nearest_) end = (nearest_ + a.z) / (a.z - b.z);
        const glm::dvec3 from = a + begin * (b - a), to = a + end * (b - a);
        const glm::dvec2 p = screen(from), q = screen(to);
        double first = 0.0, last = 1.0;
        for (int axis = 0; axis < 2; ++axis) {
            const double most = axis == 0 ? width : height, way = q[axis] - p[axis];
            if (way == 0.0 && (p[axis] < 0.0 || p[axis] > most)) return;
            if (way == 0.0) continue;
            first = std::max(first, std::min(-p[axis] / way, (most - p[axis]) / way));
            last = std::min(last, std::max(-p[axis] / way, (most - p[axis]) / way));
        }
        const auto count = static_cast<int>((last - first) * glm::distance(p, q) / every);
        for (int i = 0; i < count; ++i) {
            const double s = first + (last - first) * (i + 0.5) / count;
            const double share = perspective_ ? s / to.z / ((1.0 - s) / from.z + s / to.z) : s;
            take(begin + share * (end - begin), seen(from + share * (to - from), edge.triangles));
        }
    }

  private:
    glm::dvec2 screen(const glm::dvec3& at) const {
        const double unit = perspective_ ? scale_ / -at.z : scale_;
        return {0.5 * width + unit * at.x, 0.5 * height - unit * at.y};
    }
    glm::dvec3 normal(std::uint32_t triangle) const {
        const auto [i, j, k] = mesh_.triangles[triangle];
        const glm::dvec3 a(mesh_.positions[i]);
        return glm::normalize(
            glm::cross(glm::dvec3(mesh_.positions[j]) - a, glm::dvec3(mesh_.positions[k]) - a));
    }
    /// The cosine of what is between a triangle's normal and the way to the eye.
    double side(std::uint32_t triangle) const {
        const auto [i, j, k] = mesh_.triangles[triangle];
        // Corners may be nearer to one another than eye space tells apart.
        const glm::dvec3 a(mesh_.positions[i]);
        const glm::dvec3 u = turn_ * (glm::dvec3(mesh_.positions[j]) - a),
                         v = turn_ * (glm::dvec3(mesh_.positions[k]) - a), area = glm::cross(u, v);
        const glm::dvec3 way = perspective_ ? -eye_[i] : glm::dvec3(0.0, 0.0, 1.0);
        // A needle has no side.
        if (!(glm::length(area) > 1e-9 * glm::length(u) * glm::length(v))) return 0.0;
        return glm::dot(glm::normalize(area), glm::normalize(way));
    }
    bool seen(const glm::dvec3& at, const std::array<std::uint32_t, 2>& own) const {
        const glm::dvec3 towards = perspective_ ? glm::normalize(-at) : glm::dvec3(0.0, 0.0, 1.0);
        for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
            if (i == own[0] || i == own[1]) continue;
            const auto& corners = mesh_.triangles[i];
            const glm::dvec3 a = eye_[corners[0]], u = eye_[corners[1]] - a, v = eye_[corners[2]] - a;
            const glm::dvec3 p = glm::cross(towards, v);
            const double turn = glm::dot(u, p);
            if (turn == 0.0) continue;
            const glm::dvec3 off = at - a, q = glm::cross(off, u);
            const double one = glm::dot(off, p) / turn, other = glm::dot(towards, q) / turn;
            if (one < 0.0 || other < 0.0 || one + other > 1.0) continue;
            const double away = glm::dot(v, q) / turn;
            if (away > 1e-6 * size_ && -(at + away * towards).z >= nearest_) return false;
        }
        return true;
    }

    const storage::SurfaceMesh& mesh_;
    const bool perspective_;
    const double nearest_, scale_;
    glm::dmat3 turn_{1.0};
    std::vector<glm::dvec3> eye_;
    double size_ = 0.0;
};

/// Places that were tried, and in how many of them both say the same.
struct Agreement {
    std::size_t places = 0, alike = 0, missed = 0, hidden = 0, lost = 0, whole = 0;
};

using EdgeKey = std::pair<std::array<std::uint32_t, 2>, std::array<std::uint32_t, 2>>;

/// `likely`: what is seen in each pixel is tried first, and what lies far behind it is not tried.
void compare(const MeshSurface& surface, const FramePlan& plan, const glm::dmat4& transform, bool likely,
             Agreement& total) {
    const LineView view(plan, transform);
    const auto pictures = modalitiesOf(surface, transform, test::usualInk(), plan, {});
    const HiderSearch search{.sampling = 0.5,
                             .likely = likely ? &pictures.triangle : nullptr,
                             .farthest = likely ? &pictures.farthest : nullptr};
    const auto edges = linesOf(surface, view, crease, {});
    std::map<EdgeKey, LineKind> lines;
    for (const auto& edge : edges) lines[{edge.vertices, edge.triangles}] = edge.kind;
    std::map<EdgeKey, std::vector<Span>> pieces;
    for (const auto& piece : visible(surface, view, edges, search, {}))
        pieces[{piece.vertices, piece.triangles}].push_back(piece.piece);
    const Oracle oracle(surface.mesh(), plan, transform);
    for (const auto& edge : surface.mesh().edges) {
        LineKind kind{};
        const auto drawn = oracle.drawn(edge, kind);
        if (drawn == Drawn::undecided) continue;
        const EdgeKey key{edge.vertices, edge.triangles};
        std::size_t tried = 0, seenThere = 0, found = 0;
        oracle.places(edge, [&](double share, bool seen) {
            const auto& all = pieces[key];
            const bool has = std::any_of(all.begin(), all.end(), [&](const Span& span) {
                return span.begin <= share && share <= span.end;
            });
            const bool wanted = drawn == Drawn::yes && seen;
            ++tried;
            seenThere += wanted;
            found += has;
            total.hidden += drawn == Drawn::yes && !seen;
            if (drawn == Drawn::no && !has) return;
            ++total.places;
            total.alike += has == wanted;
            total.missed += wanted && !has;
        });
        if (tried == 0) continue;
        if (drawn == Drawn::yes) {
            ASSERT_TRUE(lines.contains(key)) << static_cast<int>(kind);
            EXPECT_EQ(static_cast<int>(lines[key]), static_cast<int>(kind));
        }
        if (seenThere < tried) continue;
        ++total.whole;
        if (found < tried) ++total.lost;
    }
}

TEST(VisibleLines, AreThoseThatATrialOfAllTrianglesFinds) {
    test::Random random(12);
    Agreement all;
    for (const auto form : test::meshForms()) {
        Agreement total;
        for (std::uint32_t number = 0; number < 4; ++number) {
            const auto surface = test::surfaceOf(test::meshOf(std::string(form), number, 0)->mesh());
            for (int i = 0; i < 12; ++i) {
                const auto transform = test::anyTransform(random);
                const auto camera = test::anyCamera(random, surface->bounds().transformed(transform));
                compare(*surface, test::planOf(camera, width, height), transform, i % 3 != 0, total);
            }
        }
        const double share = static_cast<double>(total.alike) / static_cast<double>(total.places);
        EXPECT_GE(share, 0.995) << form;
        // Narrow triangles may be missed; what is seen may not.
        EXPECT_LE(static_cast<double>(total.missed), 1e-4 * static_cast<double>(total.places)) << form;
        EXPECT_LE(static_cast<double>(total.lost), 0.002 * static_cast<double>(total.whole)) << form;
        all.places += total.places;
        all.hidden += total.hidden;
    }
    EXPECT_GT(all.places, 100000U);
    EXPECT_GT(all.hidden, 10000U);
}

TEST(VisibleLines, ARequestToStopIsHeard) {
    const auto surface = test::surfaceOf(test::meshOf("leaves", 0, 0)->mesh());
    const LineView view(test::planOf(fitCamera(surface->bounds(), 1.0), 64, 64), glm::dmat4(1.0));
    std::stop_source source;
    source.request_stop();
    EXPECT_TRUE(linesOf(*surface, view, crease, source.get_token()).empty());
    const auto edges = linesOf(*surface, view, crease, {});
    EXPECT_FALSE(edges.empty());
    EXPECT_TRUE(visible(*surface, view, edges, {.sampling = 0.5}, source.get_token()).empty());
    EXPECT_TRUE(chained(*surface, view, edges, 1.0, source.get_token()).empty());
}

// What surroundings keep away of the ambient light, against closed forms.

constexpr std::uint32_t occlusionSide = 96;

/// Rectangles, each by a corner and its sides.
struct Rectangle {
    glm::vec3 corner, right, up;
};

MeshSurface surfaceOf(const std::vector<Rectangle>& rectangles) {
    storage::SurfaceMesh mesh;
    Bounds bounds{glm::dvec3(HUGE_VAL), glm::dvec3(-HUGE_VAL)};
    for (const auto& [corner, right, up] : rectangles) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        const glm::vec3 normal = glm::normalize(glm::cross(right, up));
        for (const auto& at : {corner, corner + right, corner + right + up, corner + up}) {
            mesh.positions.push_back(at);
            mesh.normals.push_back(normal);
            bounds = bounds.united({glm::dvec3(at), glm::dvec3(at)});
        }
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.triangles.push_back({first, first + 2, first + 3});
    }
    mesh.edges = test::edgesOf(mesh);
    return {std::move(mesh), bounds};
}

/// Grey under ambient light alone, seen from above.
Raster<float> greyOf(const MeshSurface& surface, double height, double occlusion) {
    Camera camera;
    camera.eye = {0.0, 0.0, 50.0};
    camera.target = glm::dvec3(0.0);
    camera.up = {0.0, 1.0, 0.0};
    camera.orthographicHeight = height;
    auto style = test::usualInk();
    style.light.ambient = 1.0;
    style.light.diffuse = 0.0;
    style.occlusion = occlusion;
    return modalitiesOf(surface, glm::dmat4(1.0), style, test::planOf(camera, occlusionSide, occlusionSide),
                        {})
        .modalities.grey;
}

const Rectangle floor{{-10.0F, -10.0F, 0.0F}, {20.0F, 0.0F, 0.0F}, {0.0F, 20.0F, 0.0F}};

TEST(AmbientOcclusion, NothingKeepsLightFromAPlain) {
    for (const float value : greyOf(surfaceOf({floor}), 8.0, 1.0).values) EXPECT_EQ(value, 1.0F);
}

TEST(AmbientOcclusion, AWallKeepsAwayWhatItCoversOfTheSky) {
    // Along x at y = 0, as high as 1: at the distance d it covers (1 - cos(atan(1 / d))) / 2 of the light.
    const Rectangle wall{{-10.0F, 0.0F, 0.0F}, {20.0F, 0.0F, 0.0F}, {0.0F, 0.0F, 1.0F}};
    const auto surface = surfaceOf({floor, wall});
    for (const double occlusion : {1.0, 0.5}) {
        const auto grey = greyOf(surface, 8.0, occlusion);
        for (const double distance : {0.3, 0.6, 1.0, 2.0}) {
            const auto row = static_cast<std::uint32_t>(occlusionSide / 2 - distance / 8.0 * occlusionSide);
            const double there = (occlusionSide / 2 - row - 0.5) * 8.0 / occlusionSide;
            double mean = 0.0;
            for (std::uint32_t column = 16; column < occlusionSide - 16; ++column)
                mean += static_cast<double>(grey.at(column, row)) / (occlusionSide - 32);
            const double closed = 0.5 * (1.0 - std::cos(std::atan(1.0 / there)));
            EXPECT_NEAR(mean, 1.0 - occlusion * closed, 0.03) << "at " << there;
        }
    }
}

TEST(AmbientOcclusion, WhatIsFarAwayKeepsNothing) {
    // A ceiling that begins beside the picture: rays end before they reach it.
    const Rectangle ceiling{{-10.0F, 5.0F, 9.0F}, {20.0F, 0.0F, 0.0F}, {0.0F, 5.0F, 0.0F}};
    for (const float value : greyOf(surfaceOf({floor, ceiling}), 4.0, 1.0).values) EXPECT_EQ(value, 1.0F);
}

TEST(AmbientOcclusion, TheShareThatItHasCounts) {
    const Rectangle wall{{-10.0F, 0.0F, 0.0F}, {20.0F, 0.0F, 0.0F}, {0.0F, 0.0F, 1.0F}};
    const auto surface = surfaceOf({floor, wall});
    const auto none = greyOf(surface, 8.0, 0.0), half = greyOf(surface, 8.0, 0.5),
               all = greyOf(surface, 8.0, 1.0);
    for (std::size_t i = 0; i < none.values.size(); ++i) {
        EXPECT_EQ(none.values[i], 1.0F);
        EXPECT_NEAR(half.values[i], 0.5F * (none.values[i] + all.values[i]), 1e-5F);
    }
}

// Lines of pictures in motion, against those of pictures at rest.

constexpr std::uint32_t quickSide = 240;

struct Seen {
    Modalities modalities;
    std::vector<InkLine> quick, exact;
};

Seen seenOf(const MeshSurface& surface, const Camera& camera) {
    auto plan = test::planOf(camera, quickSide, quickSide);
    const LineView view(plan, glm::dmat4(1.0));
    const auto edges = linesOf(surface, view, 60.0, {});
    const auto still = modalitiesOf(surface, glm::dmat4(1.0), test::usualInk(), plan, {});
    const auto pieces = visible(surface, view, edges, {.sampling = 0.35}, {});
    plan.exact = false;
    auto moving = modalitiesOf(surface, glm::dmat4(1.0), test::usualInk(), plan, {});
    Seen seen{std::move(moving.modalities), {}, {}};
    seen.quick = quickLines(surface, view, edges, seen.modalities, {});
    seen.exact = chained(surface, view, pieces, still.modalities.extent, {});
    return seen;
}

TEST(QuickLines, LieWhereTheExactOnesDo) {
    for (const auto form : test::meshForms()) {
        test::Random random(3);
        const auto surface = test::meshOf(std::string(form), 1, 200);
        double off = 0.0, all = 0.0;
        for (int i = 0; i < 4; ++i) {
            Camera camera;
            const Bounds& bounds = surface->bounds();
            camera.target = bounds.center();
            camera.eye = camera.target + 2.0 * glm::length(bounds.size()) * random.direction();
            camera.up = random.direction();
            camera.fovYDegrees = 35.0;
            const auto seen = seenOf(*surface, camera);
            const auto quick = blurred(coverOf(seen.quick, quickSide, quickSide, 1.2), 3.0);
            const auto exact = blurred(coverOf(seen.exact, quickSide, quickSide, 1.2), 3.0);
            for (std::size_t k = 0; k < quick.values.size(); ++k) {
                off += static_cast<double>(std::abs(quick.values[k] - exact.values[k]));
                all += static_cast<double>(exact.values[k]);
            }
        }
        EXPECT_LT(off, 0.35 * all + 1.0) << form;
    }
}

/// Lines everywhere in a square, all alike.
std::vector<InkLine> crowd(std::size_t count) {
    test::Random random(5);
    std::vector<InkLine> lines;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec2 at(random.between(4.0, quickSide - 4.0), random.between(4.0, quickSide - 4.0));
        const double angle = random.between(0.0, 3.0);
        const glm::dvec2 way = 3.0 * glm::dvec2(std::cos(angle), std::sin(angle));
        lines.push_back({LineKind::border,
                         {{at, 1.0, 0.0}, {at + way, 1.0, 0.0}},
                         static_cast<float>(random.between(0.0, 1.0))});
    }
    return lines;
}

TEST(QuickLines, ACrowdIsThinnedOutToTheTone) {
    const auto lines = crowd(20000);
    const ToneCells cells(quickSide, quickSide, 6.0);
    for (const float tone : {0.1F, 0.3F, 0.5F}) {
        const ToneGrid target(cells.columns, cells.rows, tone);
        const auto chosen =
            chooseLines(lines, test::usualInk().silhouettes, {cells, target, 1.0, 12.0, true}, {});
        EXPECT_EQ(chosen.lines.size() + chosen.left.size(), lines.size());
        double mean = 0.0, count = 0.0;
        for (std::uint32_t row = cells.rows / 4; row < 3 * cells.rows / 4; ++row) {
            for (std::uint32_t column = cells.columns / 4; column < 3 * cells.columns / 4; ++column) {
                mean += 1.0 - std::exp(-static_cast<double>(chosen.density.at(column, row)));
                count += 1.0;
            }
        }
        EXPECT_NEAR(mean / count, tone, 0.03);
    }
}

TEST(QuickLines, LinesThatAreDrawnStayAsItGrowsDarker) {
    const auto lines = crowd(5000);
    const ToneCells cells(quickSide, quickSide, 6.0);
    std::set<std::pair<double, double>> before;
    for (const float tone : {0.05F, 0.1F, 0.2F}) {
        const ToneGrid target(cells.columns, cells.rows, tone);
        std::set<std::pair<double, double>> drawn;
        for (const auto& line :
             chooseLines(lines, test::usualInk().silhouettes, {cells, target, 1.0, 12.0, true}, {}).lines)
            drawn.emplace(line.points[0].at.x, line.points[0].at.y);
        EXPECT_TRUE(std::includes(drawn.begin(), drawn.end(), before.begin(), before.end()));
        EXPECT_GT(drawn.size(), before.size());
        before = drawn;
    }
}

// The choice of lines: the tone that is drawn, blurred by a plain Gaussian, meets its target; what must be
// drawn is; the order of lines does not matter.

constexpr std::uint32_t targetColumns = 192, targetRows = 144;
constexpr double targetReading = 6.0, lineWidth = 1.2;

/// Straight, of points some pixels apart, each with a step of its own of at most `most`.
InkLine anyLine(test::Random& random, double most) {
    InkLine line;
    const glm::dvec2 from(random.between(-20.0, targetColumns + 20.0),
                          random.between(-20.0, targetRows + 20.0));
    const double angle = random.between(0.0, 6.3);
    const auto count = 8 + random.below(20);
    for (std::uint64_t i = 0; i < count; ++i) {
        const glm::dvec2 at =
            from + 5.0 * static_cast<double>(i) * glm::dvec2(std::cos(angle), std::sin(angle));
        line.points.push_back({at, 1.0, most * random.unit()});
    }
    return line;
}

std::vector<InkLine> manyLines(test::Random& random, std::size_t count, double most) {
    std::vector<InkLine> lines;
    while (lines.size() < count) lines.push_back(anyLine(random, most));
    return lines;
}

struct Target {
    ToneCells cells{targetColumns, targetRows, targetReading};
    ToneGrid grid;

    explicit Target(double tone) : grid(cells.columns, cells.rows, static_cast<float>(tone)) {}
    ChosenLines chosen(const std::vector<InkLine>& lines, const SilhouetteStyle& style) const {
        return chooseLines(lines, style, {cells, grid, lineWidth, 2.0 * targetReading}, {});
    }
};

/// By a Gaussian as it stands in books.
Raster<double> plainlyBlurred(const Raster<double>& picture, double deviation) {
    const int reach = static_cast<int>(4.0 * deviation);
    Raster<double> across(picture.width, picture.height), made = across;
    const auto pass = [&](const Raster<double>& from, Raster<double>& to, bool sideways) {
        for (std::uint32_t row = 0; row < from.height; ++row) {
            for (std::uint32_t column = 0; column < from.width; ++column) {
                double sum = 0.0, weights = 0.0;
                for (int i = -reach; i <= reach; ++i) {
                    const double weight = std::exp(-0.5 * i * i / (deviation * deviation));
                    sum += weight * from.near(column + (sideways ? i : 0), row + (sideways ? 0 : i));
                    weights += weight;
                }
                to.at(column, row) = sum / weights;
            }
        }
    };
    pass(picture, across, true);
    pass(across, made, false);
    return made;
}

/// The mean of what the blurred tone is off.
double errorOf(const std::vector<InkLine>& lines, double tone) {
    Strokes strokes;
    for (const auto& line : lines) {
        std::vector<glm::dvec2> places;
        for (const auto& point : line.points) places.push_back(point.at);
        test::addStroke(strokes, places, lineWidth);
    }
    auto off = plainlyBlurred(test::coverOf(strokes, targetColumns, targetRows), targetReading);
    for (auto& value : off.values) value = std::abs(value - tone);
    return test::meanOf(off, 0);
}

using Way = std::array<double, 4>;

std::vector<Way> waysOf(const std::vector<InkLine>& lines) {
    std::vector<Way> ways;
    for (const auto& line : lines) {
        for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
            const auto &a = line.points[i].at, &b = line.points[i + 1].at;
            ways.push_back({a.x, a.y, b.x, b.y});
        }
    }
    std::sort(ways.begin(), ways.end());
    return ways;
}

TEST(ChooseLines, AdjustedMeetsTheTarget) {
    test::Random random(8);
    for (const double tone : {0.1, 0.25, 0.45}) {
        const auto lines = manyLines(random, 900, 1.0);
        const Target target(tone);
        auto style = test::usualInk().silhouettes;
        style.mode = SilhouetteMode::all;
        const double all = errorOf(target.chosen(lines, style).lines, tone);
        style.mode = SilhouetteMode::adjusted;
        const double adjusted = errorOf(target.chosen(lines, style).lines, tone);
        EXPECT_GT(all, 0.25) << tone;
        EXPECT_LT(adjusted, 0.06) << tone;
    }
}

TEST(ChooseLines, WhereLinesAreNotTooDarkAllAreDrawn) {
    test::Random random(9);
    const auto lines = manyLines(random, 30, 1.0);
    EXPECT_EQ(waysOf(Target(0.8).chosen(lines, test::usualInk().silhouettes).lines), waysOf(lines));
}

/// On white paper, where tone asks for none.
TEST(ChooseLines, OuterContoursAndImportantLinesAreWholeButInCrowds) {
    test::Random random(12);
    const auto ofStep = [&](int count, double step) {
        auto lines = manyLines(random, count, 1.0);
        for (auto& line : lines) {
            for (auto& point : line.points) point.step = step;
        }
        return lines;
    };
    const Target paper(0.0);
    auto style = test::usualInk().silhouettes;
    const auto outer = ofStep(4, 1.0), inner = ofStep(4, 0.5), crowd = ofStep(900, 1.0);
    EXPECT_EQ(waysOf(paper.chosen(outer, style).lines), waysOf(outer));
    EXPECT_LT(waysOf(paper.chosen(inner, style).lines).size(), waysOf(inner).size());
    style.importance = 0.05;
    EXPECT_EQ(waysOf(paper.chosen(inner, style).lines), waysOf(inner));
    EXPECT_LT(waysOf(paper.chosen(crowd, style).lines).size(), waysOf(crowd).size() / 2);
}

TEST(ChooseLines, ImportantDrawsThoseAboveAndNoneNothing) {
    test::Random random(10);
    const auto lines = manyLines(random, 200, 1.0);
    const double threshold = 0.5;
    // Pieces as long as a target says, or what is left at a line's end: of the mean step.
    std::vector<InkLine> above;
    for (const auto& line : lines) {
        for (std::size_t begin = 0; begin + 1 < line.points.size();) {
            const std::size_t end = std::min(begin + 3, line.points.size() - 1);
            double steps = 0.0;
            for (std::size_t i = begin; i < end; ++i) steps += line.points[i].step;
            if (steps > threshold * static_cast<double>(end - begin))
                above.push_back({line.kind,
                                 {line.points.begin() + static_cast<std::ptrdiff_t>(begin),
                                  line.points.begin() + static_cast<std::ptrdiff_t>(end) + 1}});
            begin = end;
        }
    }
    const Target target(0.05);
    auto style = test::usualInk().silhouettes;
    style.mode = SilhouetteMode::important;
    style.importance = threshold;
    const auto important = waysOf(target.chosen(lines, style).lines);
    EXPECT_EQ(important, waysOf(above));
    EXPECT_LT(important.size(), waysOf(lines).size());

    style.mode = SilhouetteMode::adjusted;
    const auto adjusted = waysOf(target.chosen(lines, style).lines);
    EXPECT_TRUE(std::includes(adjusted.begin(), adjusted.end(), important.begin(), important.end()));

    style.mode = SilhouetteMode::none;
    const auto none = target.chosen(lines, style);
    EXPECT_TRUE(none.lines.empty());
    EXPECT_EQ(none.density, ToneGrid(target.cells.columns, target.cells.rows));
}

TEST(ChooseLines, TheOrderOfLinesDoesNotMatter) {
    test::Random random(11);
    auto lines = manyLines(random, 300, 1.0);
    const Target target(0.2);
    const auto before = waysOf(target.chosen(lines, test::usualInk().silhouettes).lines);
    for (std::size_t i = lines.size() - 1; i > 0; --i) std::swap(lines[i], lines[random.below(i + 1)]);
    EXPECT_EQ(waysOf(target.chosen(lines, test::usualInk().silhouettes).lines), before);
    EXPECT_LT(before.size(), waysOf(lines).size());
}

TEST(ChooseLines, DensityIsThatOfWhatIsDrawn) {
    test::Random random(12);
    const auto lines = manyLines(random, 300, 1.0);
    const Target target(0.2);
    const auto chosen = target.chosen(lines, test::usualInk().silhouettes);
    const auto again = densityOf(chosen.lines, target.cells, lineWidth);
    double most = 0.0;
    // What is blurred beyond a side comes back in one of them.
    for (std::uint32_t row = 12; row + 12 < again.height; ++row) {
        for (std::uint32_t column = 12; column + 12 < again.width; ++column)
            most = std::max(most,
                            std::abs(double(again.at(column, row)) - double(chosen.density.at(column, row))));
    }
    EXPECT_LT(most, 1e-4);
}

TEST(ChooseLines, ExtremesDoNoHarm) {
    test::Random random(13);
    auto lines = manyLines(random, 20, 1.0);
    lines.push_back({LineKind::crease, {{{3.0, 3.0}}, {{3.0, 3.0}}}});
    lines.push_back({LineKind::crease, {{{-1e9, 3.0}}, {{1e9, 4.0}}}});
    for (const double size : {1.0, 6.0, 256.0}) {
        const ToneCells cells(64, 48, size);
        for (const float tone : {0.0F, 1.0F, std::nanf("")}) {
            const ToneGrid grid(cells.columns, cells.rows, tone);
            for (const double width : {0.1, 64.0})
                EXPECT_LE(
                    chooseLines(lines, test::usualInk().silhouettes, {cells, grid, width, 2.0 * size}, {})
                        .lines.size(),
                    500U);
        }
    }
}

}  // namespace
}  // namespace mote::render
