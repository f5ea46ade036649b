// SPDX-License-Identifier: GPL-3.0-or-later
//
// What drawings as a whole are held to, in the default style and from anywhere: outer contours without a gap,
// no crumbs, hatches that follow the curvature of surfaces whose curvature is known. The oracles share no
// code with what is drawn: pixels are found by trying all triangles, curvature by differences of a formula.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "server/render/layers/ink/lower_ink.h"
#include "server/render/layers/ink/mesh_modalities.h"
#include "tests/support/generated_mesh.h"
#include "tests/support/random.h"
#include "tests/unit/ink/ink_views.h"

namespace mote::render {
namespace {

constexpr double halfTurn = std::numbers::pi;

InkStyle defaultInk() {
    return inkStyleOf(parseInkStyle({}, glm::dvec3(1.0)).value());
}

Strokes drawingOf(const std::shared_ptr<const MeshSurface>& surface, const InkStyle& style,
                  const FramePlan& plan) {
    const Layer layer{.dataset = "data/a", .style = proto::InkStyle()};
    return inkOf(layer, style, surface, plan, 1.0, {}).strokes;
}

/// take(from, to) for each straight part of each stroke.
template <class Take>
void eachStraightPart(const Strokes& strokes, const Take& take) {
    for (const auto& line : strokes.lines) {
        for (auto i = line.begin; i + 1 < line.end; ++i) {
            const auto &from = strokes.points[i], &to = strokes.points[i + 1];
            take(glm::dvec2(from.x, from.y), glm::dvec2(to.x, to.y));
        }
    }
}

double distanceToPart(const glm::dvec2& place, const glm::dvec2& from, const glm::dvec2& to) {
    const glm::dvec2 way = to - from;
    const double square = glm::dot(way, way);
    const double share = square > 0.0 ? std::clamp(glm::dot(place - from, way) / square, 0.0, 1.0) : 0.0;
    return glm::distance(place, from + share * way);
}

/// The pixels in whose middles a mesh is seen, by trying all triangles.
class SeenByTrial {
  public:
    SeenByTrial(const storage::SurfaceMesh& mesh, const FramePlan& plan)
        : plan_(plan), unit_(plan.height / (2.0 * plan.camera.halfHeight())), seen_(plan.width, plan.height) {
        const glm::dmat4 toEye = plan.camera.worldToEye();
        for (const auto& triangle : mesh.triangles) {
            std::array<glm::dvec3, 3> corners;
            for (std::size_t i = 0; i < 3; ++i)
                corners[i] = glm::dvec3(toEye * glm::dvec4(glm::dvec3(mesh.positions[triangle[i]]), 1.0));
            add(corners);
        }
    }
    bool at(std::uint32_t column, std::uint32_t row) const { return seen_.at(column, row) != 0; }

  private:
    glm::dvec2 onScreen(const glm::dvec3& eye) const {
        const double scale = unit_ / (plan_.camera.perspective() ? -eye.z : 1.0);
        return 0.5 * glm::dvec2(plan_.width, plan_.height) + scale * glm::dvec2(eye.x, -eye.y);
    }
    void add(const std::array<glm::dvec3, 3>& corners) {
        glm::dvec2 least(0.0), most(plan_.width, plan_.height);
        const double nearest = nearLimit(plan_.camera);
        if (std::all_of(corners.begin(), corners.end(), [&](const auto& at) { return -at.z > nearest; })) {
            const auto a = onScreen(corners[0]), b = onScreen(corners[1]), c = onScreen(corners[2]);
            least = glm::max(least, glm::min(a, glm::min(b, c)) - 1.0);
            most = glm::min(most, glm::max(a, glm::max(b, c)) + 1.0);
        }
        for (double y = std::floor(least.y); y < most.y; y += 1.0) {
            for (double x = std::floor(least.x); x < most.x; x += 1.0) {
                if (meets(corners, {x + 0.5, y + 0.5}))
                    seen_.at(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)) = 1;
            }
        }
    }
    /// (Cramer's rule; sides belong to the triangle, so that nothing shows through between two.)
    bool meets(const std::array<glm::dvec3, 3>& corners, const glm::dvec2& pixel) const {
        const glm::dvec2 window =
            (pixel - 0.5 * glm::dvec2(plan_.width, plan_.height)) / unit_ * glm::dvec2(1.0, -1.0);
        const bool perspective = plan_.camera.perspective();
        const glm::dvec3 origin = perspective ? glm::dvec3(0.0) : glm::dvec3(window, 0.0);
        const glm::dvec3 way = perspective ? glm::dvec3(window, -1.0) : glm::dvec3(0.0, 0.0, -1.0);
        const glm::dvec3 one = corners[1] - corners[0], two = corners[2] - corners[0];
        const double volume = glm::determinant(glm::dmat3(one, two, -way));
        if (volume == 0.0) return false;
        const glm::dvec3 off = origin - corners[0];
        const double u = glm::determinant(glm::dmat3(off, two, -way)) / volume,
                     v = glm::determinant(glm::dmat3(one, off, -way)) / volume,
                     depth = glm::determinant(glm::dmat3(one, two, off)) / volume;
        constexpr double slack = -1e-9;
        return u >= slack && v >= slack && u + v <= 1.0 - slack && depth >= nearLimit(plan_.camera);
    }

    const FramePlan& plan_;
    const double unit_;
    Raster<std::uint8_t> seen_;
};

struct Gaps {
    double contour = 0.0, without = 0.0;

    void operator+=(const Gaps& other) {
        contour += other.contour;
        without += other.without;
    }
};

/// Of the borders between pixels that see a mesh and pixels that see nothing, those with no line within two
/// pixels.
Gaps gapsOf(const SeenByTrial& seen, const Strokes& strokes, std::uint32_t width, std::uint32_t height) {
    constexpr double reach = 2.0;
    Raster<std::uint8_t> near(2 * width, 2 * height);  // squares of half a pixel; those of pixels' borders
    eachStraightPart(strokes, [&](const glm::dvec2& from, const glm::dvec2& to) {
        const glm::dvec2 least = 2.0 * (glm::min(from, to) - reach),
                         most = 2.0 * (glm::max(from, to) + reach);
        for (double y = std::max(0.0, std::floor(least.y)); y < std::min(2.0 * height, most.y); y += 1.0) {
            for (double x = std::max(0.0, std::floor(least.x)); x < std::min(2.0 * width, most.x); x += 1.0) {
                if (distanceToPart({0.5 * x, 0.5 * y}, from, to) <= reach)
                    near.at(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)) = 1;
            }
        }
    });
    Gaps gaps;
    const auto meet = [&](std::uint32_t x, std::uint32_t y, bool one, bool other) {
        if (one == other) return;
        gaps.contour += 1.0;
        gaps.without += near.at(x, y) == 0 ? 1.0 : 0.0;
    };
    for (std::uint32_t row = 0; row < height; ++row) {
        for (std::uint32_t column = 0; column < width; ++column) {
            const bool here = seen.at(column, row);
            if (column + 1 < width) meet(2 * column + 2, 2 * row + 1, here, seen.at(column + 1, row));
            if (row + 1 < height) meet(2 * column + 1, 2 * row + 2, here, seen.at(column, row + 1));
        }
    }
    return gaps;
}

/// A crowd of triangles in a ball, as a tree is one of leaves.
std::shared_ptr<const MeshSurface> crowd(test::Random& random) {
    storage::SurfaceMesh mesh;
    for (std::uint32_t i = 0; i < 500; ++i) {
        const glm::dvec3 middle = std::cbrt(random.between(0.0, 1.0)) * random.direction();
        const glm::dvec3 normal = random.direction();
        const glm::dvec3 right = 0.08 * glm::normalize(glm::cross(normal, random.direction()));
        for (const auto& off : {right, glm::cross(normal, right), -right}) {
            mesh.positions.emplace_back(middle + off);
            mesh.normals.emplace_back(normal);
        }
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return test::surfaceOf(std::move(mesh));
}

TEST(DrawingBars, OuterContoursAreWholeFromAnywhere) {
    constexpr std::uint32_t width = 240, height = 180;
    auto style = defaultInk();
    style.hatch.strength = 0.0;  // a hatch is no contour
    test::Random random(34);
    for (std::size_t form = 0; form <= test::meshForms().size(); ++form) {
        for (const bool exact : {true, false}) {
            Gaps gaps;
            for (std::uint32_t i = 0; i < 10; ++i) {
                const auto surface = form < test::meshForms().size()
                                         ? test::meshOf(std::string(test::meshForms()[form]), i, 0)
                                         : crowd(random);
                auto plan = test::planOf(i == 0 ? fitCamera(surface->bounds(), 4.0 / 3.0)
                                                : test::anyCamera(random, surface->bounds()),
                                         width, height);
                plan.exact = exact;
                gaps += gapsOf(SeenByTrial(surface->mesh(), plan), drawingOf(surface, style, plan), width,
                               height);
            }
            RecordProperty(fmt::format("percentOfForm{}{}", form, exact ? "" : "InMotion"),
                           fmt::format("{:.4f}", 100.0 * gaps.without / gaps.contour));
            EXPECT_GT(gaps.contour, 500.0);
            EXPECT_LE(gaps.without, 0.002 * gaps.contour) << "form " << form << ", exact " << exact;
        }
    }
}

/// In films lines stay, and new ones come only where an outer contour has none.
TEST(DrawingBars, OuterContoursOfFilmsAreWhole) {
    constexpr std::uint32_t width = 240, height = 180;
    auto style = defaultInk();
    style.hatch.strength = 0.0;
    test::Random random(38);
    Gaps gaps;
    for (int form = 0; form < 3; ++form) {
        const auto surface = crowd(random);
        const Layer layer{.dataset = "data/a", .style = proto::InkStyle()};
        const auto camera = fitCamera(surface->bounds(), 4.0 / 3.0);
        const glm::dvec3 off = camera.eye - camera.target, up = glm::normalize(camera.up);
        InkMemory memory;
        for (int frame = 0; frame < 8; ++frame) {
            auto turned = camera;
            const double angle = frame * halfTurn / 90.0;
            turned.eye = camera.target + std::cos(angle) * off + std::sin(angle) * glm::cross(up, off) +
                         (1.0 - std::cos(angle)) * glm::dot(up, off) * up;
            const auto plan = test::planOf(turned, width, height);
            const auto drawing = inkOf(layer, style, surface, plan, 1.0, {}, &memory);
            if (frame > 0) gaps += gapsOf(SeenByTrial(surface->mesh(), plan), drawing.strokes, width, height);
        }
    }
    RecordProperty("percent", fmt::format("{:.4f}", 100.0 * gaps.without / gaps.contour));
    EXPECT_GT(gaps.contour, 5000.0);
    EXPECT_LE(gaps.without, 0.002 * gaps.contour);
}

/// Of all strokes those that are shorter than one and a half spacings of hatches, with no line as near to
/// their middle.
struct Crumbs {
    double strokes = 0.0, alone = 0.0;
};

Crumbs crumbsOf(const Strokes& strokes, double spacing) {
    const double most = 1.5 * spacing;
    Crumbs made;
    for (std::size_t i = 0; i < strokes.lines.size(); ++i) {
        made.strokes += 1.0;
        double length = 0.0;
        const auto place = [&](std::uint32_t point) {
            return glm::dvec2(strokes.points[point].x, strokes.points[point].y);
        };
        const auto [begin, end] = strokes.lines[i];
        for (auto k = begin; k + 1 < end; ++k) length += glm::distance(place(k), place(k + 1));
        if (length >= most) continue;
        const auto middle = place((begin + end) / 2);
        bool alone = true;
        for (std::size_t k = 0; alone && k < strokes.lines.size(); ++k) {
            for (auto at = strokes.lines[k].begin; k != i && alone && at + 1 < strokes.lines[k].end; ++at)
                alone = distanceToPart(middle, place(at), place(at + 1)) > most;
        }
        made.alone += alone ? 1.0 : 0.0;
    }
    return made;
}

TEST(DrawingBars, ThereAreNoCrumbs) {
    const auto style = defaultInk();
    Crumbs all;
    test::Random random(36);
    for (const auto form : test::meshForms()) {
        for (std::uint32_t i = 0; i < 6; ++i) {
            const auto surface = test::meshOf(std::string(form), i, 0);
            const auto plan = test::planOf(
                i == 0 ? fitCamera(surface->bounds(), 4.0 / 3.0) : test::anyCamera(random, surface->bounds()),
                320, 240);
            const auto one = crumbsOf(drawingOf(surface, style, plan), style.hatch.spacing);
            all.strokes += one.strokes;
            all.alone += one.alone;
        }
    }
    RecordProperty("percentOfStrokes", fmt::format("{:.4f}", 100.0 * all.alone / all.strokes));
    EXPECT_GT(all.strokes, 3000.0);
    EXPECT_LE(all.alone, 0.001 * all.strokes) << all.alone << " of " << all.strokes;
}

/// A surface by a formula, over the unit square.
struct Formula {
    const char* name;
    std::function<glm::dvec3(double, double)> at;
    bool round = false;  ///< closes along u
    std::uint32_t columns = 144, rows = 96;
};

std::vector<Formula> formulas() {
    const auto turn = [](double radius, double angle) {
        return radius * glm::dvec2(std::cos(angle), std::sin(angle));
    };
    const auto graph = [](const std::function<double(double, double)>& height) {
        return [height](double u, double v) {
            const double x = 2.0 * u - 1.0, y = 2.0 * v - 1.0;
            return glm::dvec3(x, y, height(x, y));
        };
    };
    return {
        {"torus",
         [=](double u, double v) {
             const auto tube = turn(0.4, 2.0 * halfTurn * v), ring = turn(1.0 + tube.x, 2.0 * halfTurn * u);
             return glm::dvec3(ring, tube.y);
         }},
        {"ellipsoid",
         [=](double u, double v) {
             const auto side = turn(1.0, 0.02 + (halfTurn - 0.04) * v),
                        ring = turn(side.y, 2.0 * halfTurn * u);
             return glm::dvec3(1.0 * ring.x, 0.6 * ring.y, 1.5 * side.x);
         }},
        {"cylinder",
         [=](double u, double v) { return glm::dvec3(turn(0.5, 2.0 * halfTurn * u), 2.0 * v - 1.0); }},
        {"saddle", graph([](double x, double y) { return 0.5 * (x * x - y * y); })},
        {"bumps", graph([](double x, double y) {
             const auto bump = [&](double cx, double cy, double width) {
                 const double dx = x - cx, dy = y - cy;
                 return std::exp(-(dx * dx + dy * dy) / (2.0 * width * width));
             };
             return 0.5 * bump(-0.3, -0.2, 0.3) + 0.35 * bump(0.4, 0.4, 0.2) - 0.3 * bump(0.3, -0.5, 0.25);
         })}};
}

/// A place's principal directions and curvatures, by differences of the formula (do Carmo 1976, 3.3).
struct Principal {
    glm::dvec3 normal{0.0};
    std::array<glm::dvec3, 2> directions{};
    std::array<double, 2> curvatures{};
};

Principal principalOf(const Formula& formula, double u, double v) {
    constexpr double h = 1e-4;
    const auto at = [&](double du, double dv) { return formula.at(u + du * h, v + dv * h); };
    const glm::dvec3 xu = (at(1, 0) - at(-1, 0)) / (2.0 * h), xv = (at(0, 1) - at(0, -1)) / (2.0 * h);
    const glm::dvec3 xuu = (at(1, 0) - 2.0 * at(0, 0) + at(-1, 0)) / (h * h),
                     xvv = (at(0, 1) - 2.0 * at(0, 0) + at(0, -1)) / (h * h),
                     xuv = (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1)) / (4.0 * h * h);
    Principal made;
    made.normal = glm::normalize(glm::cross(xu, xv));
    // In an orthonormal frame of the tangent plane.
    const glm::dvec3 one = glm::normalize(xu), two = glm::cross(made.normal, one);
    const glm::dmat2 frame(glm::dvec2(glm::dot(xu, one), glm::dot(xu, two)),
                           glm::dvec2(glm::dot(xv, one), glm::dot(xv, two)));
    const double l = glm::dot(xuu, made.normal), m = glm::dot(xuv, made.normal),
                 n = glm::dot(xvv, made.normal);
    const glm::dmat2 back = glm::inverse(frame);
    const glm::dmat2 shape = glm::transpose(back) * glm::dmat2(l, m, m, n) * back;
    const double angle = 0.5 * std::atan2(2.0 * shape[0][1], shape[0][0] - shape[1][1]);
    for (std::size_t i = 0; i < 2; ++i) {
        const glm::dvec2 way(std::cos(angle + 0.5 * halfTurn * static_cast<double>(i)),
                             std::sin(angle + 0.5 * halfTurn * static_cast<double>(i)));
        made.directions[i] = way.x * one + way.y * two;
        made.curvatures[i] = glm::dot(way, shape * way);
    }
    return made;
}

struct KnownSurface {
    std::shared_ptr<const MeshSurface> surface;
    std::vector<Principal> principal;  // of vertices
};

KnownSurface knownSurface(const Formula& formula) {
    storage::SurfaceMesh mesh;
    KnownSurface made;
    for (std::uint32_t row = 0; row <= formula.rows; ++row) {
        for (std::uint32_t column = 0; column <= formula.columns; ++column) {
            const double u = column / double(formula.columns), v = row / double(formula.rows);
            made.principal.push_back(principalOf(formula, u, v));
            mesh.positions.emplace_back(formula.at(u, v));
            mesh.normals.emplace_back(made.principal.back().normal);
        }
    }
    const std::uint32_t stride = formula.columns + 1;
    for (std::uint32_t row = 0; row < formula.rows; ++row) {
        for (std::uint32_t column = 0; column < formula.columns; ++column) {
            const std::uint32_t i = row * stride + column;
            mesh.triangles.push_back({i, i + 1, i + stride + 1});
            mesh.triangles.push_back({i, i + stride + 1, i + stride});
        }
    }
    made.surface = test::surfaceOf(std::move(mesh));
    return made;
}

struct Turned {
    double length = 0.0, sum = 0.0, far = 0.0;
    double mean() const { return sum / length; }
};

/// By how much hatches lie off the nearer principal direction as it is seen on the screen, where curvatures
/// differ and the surface does not turn away.
Turned turnedOf(const KnownSurface& known, const FramePlan& plan, const InkStyle& style) {
    const auto seen = modalitiesOf(*known.surface, glm::dmat4(1.0), style, plan, {});
    const InkCamera camera{.toEye = plan.camera.worldToEye(),
                           .perspective = plan.camera.perspective(),
                           .pixels = plan.height / (2.0 * plan.camera.halfHeight()),
                           .size = {plan.width, plan.height}};
    Turned made;
    const double size = glm::length(known.surface->bounds().size());
    eachStraightPart(drawingOf(known.surface, style, plan), [&](const glm::dvec2& from,
                                                                const glm::dvec2& to) {
        const double length = glm::distance(from, to);
        const auto parts = static_cast<int>(std::ceil(length / 2.0));
        for (int i = 0; i < parts; ++i) {
            const glm::dvec2 at = glm::mix(from, to, (i + 0.5) / parts);
            const auto triangle = seen.triangle.near(at.x, at.y);
            if (triangle == MeshMeeting::none) continue;
            const auto vertex = known.surface->mesh().triangles[triangle][0];
            const auto& principal = known.principal[vertex];
            const glm::dvec3 place(known.surface->mesh().positions[vertex]);
            const glm::dvec3 toEye = glm::normalize(plan.camera.eye - place);
            if (std::abs(glm::dot(principal.normal, toEye)) < 0.3) continue;
            if (std::abs(principal.curvatures[0] - principal.curvatures[1]) * size < 0.5) continue;
            double least = halfTurn;
            for (const auto& direction : principal.directions) {
                const glm::dvec2 way =
                    camera.onPicture(place + 1e-4 * direction).at - camera.onPicture(place).at;
                const glm::dvec2 own = to - from;
                const double turn = std::abs(std::atan2(way.x * own.y - way.y * own.x, glm::dot(way, own)));
                least = std::min(least, std::min(turn, halfTurn - turn));
            }
            made.length += length / parts;
            made.sum += glm::degrees(least) * length / parts;
            made.far += least > glm::radians(20.0) ? length / parts : 0.0;
        }
    });
    return made;
}

TEST(DrawingBars, HatchesFollowTheCurvature) {
    test::Random random(35);
    for (const auto& formula : formulas()) {
        const auto known = knownSurface(formula);
        Turned all;
        for (int i = 0; i < 2; ++i) {
            auto camera = fitCamera(known.surface->bounds(), 1.0);
            if (i > 0) {
                const glm::dvec3 off = glm::length(camera.eye - camera.target) * random.direction();
                camera.eye =
                    camera.target + glm::dvec3(off.x, off.y, std::abs(off.z) + 0.3 * glm::length(off));
            }
            const auto plan = test::planOf(camera, 480, 480);
            auto style = defaultInk();
            style.silhouettes.mode = SilhouetteMode::none;
            const auto one = turnedOf(known, plan, style);
            all.length += one.length;
            all.sum += one.sum;
            all.far += one.far;
        }
        RecordProperty(fmt::format("degreesOf_{}", formula.name), fmt::format("{:.2f}", all.mean()));
        EXPECT_GT(all.length, 5000.0);
        EXPECT_LT(all.mean(), 5.0) << formula.name;
        EXPECT_LT(all.far, 0.05 * all.length) << formula.name;
    }
}

}  // namespace
}  // namespace mote::render
