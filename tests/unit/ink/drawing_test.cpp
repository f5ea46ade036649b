// SPDX-License-Identifier: GPL-3.0-or-later
//
// From a mesh to strokes: every picture that may be shown, any style, any form, any number of threads.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <utility>

#include "server/render/ink/drawing.h"
#include "server/render/ink/pen.h"
#include "server/render/layers/ink/lower_ink.h"
#include "server/render/layers/ink/mesh_modalities.h"
#include "tests/support/generated_mesh.h"
#include "tests/support/random.h"
#include "tests/unit/ink/ink_views.h"

namespace mote::render {
namespace {

constexpr std::array shows{InkPicture::drawing,  InkPicture::grey,   InkPicture::depth,
                           InkPicture::angle,    InkPicture::edges,  InkPicture::complexity,
                           InkPicture::segments, InkPicture::target, InkPicture::lighten,
                           InkPicture::darken};

struct Look {
    Camera camera;
    glm::dmat4 transform{1.0};
    std::uint32_t width = 64, height = 48;
    double pixels = 1.0;
    bool exact = true;
    std::stop_token stop = {};
};

FramePlan lowered(const InkData& data, const InkStyle& style, const Look& look) {
    auto plan = test::planOf(look.camera, look.width, look.height);
    plan.exact = look.exact;
    const Quality quality;
    SelectionCache selections;
    Lowering out{.plan = plan,
                 .quality = quality,
                 .selections = selections,
                 .device = {},
                 .reading = Reading::all,
                 .pixels = look.pixels,
                 .slabs = 192,
                 .stop = look.stop};
    const Layer layer{.dataset = "data/a", .transform = look.transform, .style = proto::InkStyle()};
    lowerInk(layer, style, data, nullptr, out);
    return plan;
}

std::shared_ptr<const MeshSurface> surfaceOf(std::string_view form, std::uint32_t number) {
    return test::surfaceOf(test::meshOf(std::string(form), number, 0)->mesh());
}

Look fitted(const MeshSurface& surface) {
    return {.camera = fitCamera(surface.bounds(), 64.0 / 48.0)};
}

TEST(InkDrawing, EveryShowIsAPictureOfTheSize) {
    for (const auto form : test::meshForms()) {
        const auto surface = surfaceOf(form, 0);
        for (const auto show : shows) {
            auto style = test::usualInk();
            style.show = show;
            const auto plan = lowered(surface, style, fitted(*surface));
            if (show == InkPicture::drawing) {
                EXPECT_TRUE(plan.fragments.empty());
                ASSERT_EQ(plan.strokes.size(), 1U) << form;
                EXPECT_FALSE(plan.strokes[0]->lines.empty());
                continue;
            }
            EXPECT_TRUE(plan.strokes.empty());
            ASSERT_EQ(plan.fragments.size(), 1U) << form;
            const auto& fragments = *plan.fragments[0];
            ASSERT_EQ(fragments.size(), 64U * 48U);
            float least = 2.0F, most = -1.0F;
            for (const auto& one : fragments) {
                EXPECT_TRUE(std::isfinite(one.depth));
                for (int i = 0; i < 3; ++i) {
                    EXPECT_TRUE(one.color[i] >= 0.0F && one.color[i] <= 1.0F);
                    least = std::min(least, one.color[i]);
                    most = std::max(most, one.color[i]);
                }
            }
            if (show != InkPicture::lighten && show != InkPicture::darken) {
                EXPECT_LT(least, most) << form << ' ' << static_cast<int>(show);
            }
        }
    }
}

TEST(InkDrawing, ARequestToStopIsHeard) {
    const auto surface = surfaceOf("leaves", 0);
    std::stop_source source;
    source.request_stop();
    auto look = fitted(*surface);
    look.width = look.height = 512;
    look.stop = source.get_token();
    for (const auto show : shows) {
        auto style = test::usualInk();
        style.show = show;
        const auto plan = lowered(surface, style, look);
        EXPECT_TRUE(plan.strokes.empty() && plan.fragments.empty());
    }
}

TEST(InkDrawing, ThreadsChangeNothing) {
    for (const auto form : test::meshForms()) {
        const auto surface = surfaceOf(form, 0);
        auto style = test::usualInk();
        style.waver = 1.0;
        style.taper = true;
        style.solid.strength = 0.7;
        auto look = fitted(*surface);
        look.width = 160;
        look.height = 120;
        tbb::task_arena one(1), more(2);
        FramePlan alone, together;
        one.execute([&] { alone = lowered(surface, style, look); });
        more.execute([&] { together = lowered(surface, style, look); });
        ASSERT_EQ(alone.strokes.size(), together.strokes.size());
        for (std::size_t i = 0; i < alone.strokes.size(); ++i)
            EXPECT_EQ(*alone.strokes[i], *together.strokes[i]) << form;
    }
}

/// The paper's tone where a ball is drawn is that of its shading, blurred.
TEST(InkDrawing, IsAsDarkAsWhatItShows) {
    const auto surface = surfaceOf("sphere", 0);
    auto style = test::usualInk();
    style.hatch.spacing = 6.0;
    auto look = fitted(*surface);
    look.width = 256;
    look.height = 192;
    look.camera.orthographicHeight = 2.0;
    const auto plan = lowered(surface, style, look);
    const auto scene = modalitiesOf(*surface, look.transform, style, plan, {}).modalities;
    const auto cover = test::coverOf(*plan.strokes.at(0), look.width, look.height);
    // Over blocks, as the eye blurs.
    constexpr std::uint32_t block = 24;
    double off = 0.0, count = 0.0;
    for (std::uint32_t top = 0; top < look.height; top += block) {
        for (std::uint32_t left = 0; left < look.width; left += block) {
            double drawn = 0.0, wanted = 0.0, pixels = 0.0;
            for (std::uint32_t y = top; y < std::min(top + block, look.height); ++y) {
                for (std::uint32_t x = left; x < std::min(left + block, look.width); ++x) {
                    drawn += cover.at(x, y);
                    wanted += std::min(0.98, 1.0 - static_cast<double>(scene.grey.at(x, y)));
                    pixels += 1.0;
                }
            }
            off += std::abs(drawn - wanted) / pixels;
            count += 1.0;
        }
    }
    EXPECT_LT(off / count, 0.06);
}

/// Values at both ends of what a style may say, and between.
InkStyle anyStyle(test::Random& random) {
    const auto number = [&](double least, double most) {
        return random.oneOf({least, most, random.between(least, most), least + 0.02 * (most - least)});
    };
    auto style = test::usualInk();
    style.silhouettes.mode =
        random.oneOf({SilhouetteMode::none, SilhouetteMode::all, SilhouetteMode::important,
                      SilhouetteMode::adjusted, SilhouetteMode::adjusted});
    style.silhouettes.importance = number(0.0, 1.0);
    style.silhouettes.width = number(0.1, 64.0);
    style.silhouettes.crease = number(0.0, 180.0);
    style.silhouettes.omit = random.chance(0.5);
    style.hatch = {.strength = number(0.0, 1.0),
                   .spacing = number(1.0, 256.0),
                   .width = number(0.1, 64.0),
                   .segments = style.hatch.segments};
    if (random.chance(0.5)) style.solid = {.strength = number(0.0, 1.0), .complexity = number(0.0, 1.0)};
    style.reading = number(1.0, 256.0);
    style.light.ambient = number(0.0, 1.0);
    style.light.shadow = random.chance(0.5);
    style.light.fixed = random.chance(0.5);
    style.inkIsDark = random.chance(0.5);
    if (random.chance(0.3)) style.show = shows[random.below(shows.size())];
    style.waver = number(0.0, 16.0);
    style.taper = random.chance(0.5);
    style.silhouettes.suggestive = random.chance(0.3);
    style.wash = {.everywhere = random.chance(0.4),
                  .color = {random.unit(), number(0.0, 1.0), random.unit()},
                  .strength = number(0.0, 1.0),
                  .tones = static_cast<int>(1 + random.below(8)),
                  .edges = number(0.0, 1.0),
                  .granulation = number(0.0, 1.0),
                  .bleed = number(0.0, 64.0)};
    for (auto count = random.below(4); count > 0 && random.chance(0.7); --count) {
        style.regions.push_back({.dabs = {random.direction(), glm::dvec3(0.0), 1e30 * random.direction()},
                                 .radius = random.oneOf({1e-300, 0.3, 2.0, 1e30}),
                                 .whole = random.chance(0.5),
                                 .fill = random.oneOf({RegionFill::usual, RegionFill::hatch, RegionFill::ink,
                                                       RegionFill::wash, RegionFill::none}),
                                 .direction = std::nullopt});
        if (random.chance(0.5)) style.regions.back().direction = number(-360.0, 360.0);
    }
    return style;
}

/// How many fragments there are.
std::size_t expectWash(const FragmentMaker& wash, const Look& look) {
    Fragments fragments;
    wash.make({0, 0, look.width, look.height}, fragments);
    for (const auto& one : fragments) {
        EXPECT_TRUE(std::isfinite(one.depth));
        EXPECT_TRUE(one.opacity > 0.0F && one.opacity <= 1.0F);
        for (int i = 0; i < 3; ++i) EXPECT_TRUE(one.color[i] >= 0.0F && std::isfinite(one.color[i]));
    }
    return fragments.size();
}

TEST(InkDrawing, AnyStyleDoesNoHarm) {
    test::Random random(21);
    std::size_t points = 0, washed = 0;
    for (int i = 0; i < 120; ++i) {
        const auto form = test::meshForms()[i % test::meshForms().size()];
        const auto surface = surfaceOf(form, static_cast<std::uint32_t>(random.below(4)));
        const auto style = anyStyle(random);
        Look look;
        look.transform = test::anyTransform(random);
        look.camera = test::anyCamera(random, surface->bounds().transformed(look.transform));
        look.pixels = random.oneOf({0.05, 0.5, 1.0, 4.0});
        look.exact = random.chance(0.5);
        if (i % 20 == 0) look.width = look.height = 1;
        const auto plan = lowered(surface, style, look);
        for (const auto& strokes : plan.strokes) {
            EXPECT_FALSE(strokes->empty());
            for (const auto& point : strokes->points) {
                EXPECT_TRUE(std::isfinite(point.x) && std::isfinite(point.y)) << i;
                EXPECT_TRUE(std::isfinite(point.width) && point.width > 0.0F) << i;
                EXPECT_TRUE(std::isfinite(point.depth)) << i;
            }
            points += strokes->points.size();
        }
        for (const auto& fragments : plan.fragments) {
            for (const auto& one : *fragments) EXPECT_TRUE(std::isfinite(one.depth)) << i;
        }
        for (const auto& wash : plan.surfaces) washed += expectWash(*wash, look);
    }
    EXPECT_GT(points, 10000U);
    EXPECT_GT(washed, 1000U);
}

// The pen: how lines and hatches lie in depth, and that the hand does no harm.

constexpr std::uint32_t penSide = 96;

/// A slope, seen on the left half alone.
Modalities halfSeen() {
    Modalities made{Raster<float>(penSide, penSide, 0.5F), Raster<float>(penSide, penSide, HUGE_VALF),
                    Raster<float>(penSide, penSide),
                    Raster<std::uint32_t>(penSide, penSide, Modalities::nothing), 2.0};
    for (std::uint32_t i = 0; i < penSide * penSide; ++i) {
        if (i % penSide < penSide / 2) made.depth.values[i] = 10.0F + 0.1F * static_cast<float>(i % penSide);
    }
    return made;
}

InkLine anyLine(test::Random& random, std::size_t points, double far) {
    InkLine line;
    for (std::size_t i = 0; i < points; ++i)
        line.points.push_back(
            {{random.between(-far, far), random.between(-far, far)}, random.between(1.0, 5.0)});
    return line;
}

void expectFinite(const Strokes& strokes) {
    for (const auto& point : strokes.points) {
        EXPECT_TRUE(std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.depth));
        EXPECT_TRUE(std::isfinite(point.width) && point.width > 0.0F);
    }
    for (const auto& line : strokes.lines) {
        EXPECT_LT(line.begin, line.end);
        EXPECT_LE(line.end, strokes.points.size());
    }
}

TEST(Pen, APlainHandDrawsTheLine) {
    const auto modalities = halfSeen();
    Strokes strokes;
    Pen pen(modalities, {}, strokes);
    const InkLine line{LineKind::crease, {{{1.0, 2.0}, 5.0}, {{3.0, 4.0}, 6.0}, {{3.0, 9.0}, 7.0}}};
    pen.draw(line, 1.5);
    ASSERT_EQ(strokes.points.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(strokes.points[i].x, static_cast<float>(line.points[i].at.x));
        EXPECT_EQ(strokes.points[i].y, static_cast<float>(line.points[i].at.y));
        EXPECT_EQ(strokes.points[i].width, 1.5F);
        EXPECT_NEAR(strokes.points[i].depth, line.points[i].depth - 1e-3 * modalities.extent, 1e-12)
            << "a little in front";
    }
}

TEST(Pen, AHatchLiesOnWhatIsSeen) {
    const auto modalities = halfSeen();
    Strokes strokes;
    Pen pen(modalities, {}, strokes);
    pen.draw(HatchStroke{{{4.0, 20.0}, {40.0, 60.0}}}, 1.0);
    for (const auto& point : strokes.points)
        EXPECT_NEAR(point.depth, 10.0 + 0.1 * static_cast<double>(point.x), 0.22);

    // Its ends lie beside what is seen: the depth is that of what is seen nearest.
    for (const auto& stroke :
         {HatchStroke{{{40.0, 5.0}, {95.0, 5.0}}}, HatchStroke{{{95.0, 5.0}, {40.0, 5.0}}}}) {
        strokes = {};
        pen.draw(stroke, 1.0);
        ASSERT_FALSE(strokes.lines.empty());
        for (const auto& point : strokes.points)
            EXPECT_TRUE(point.depth > 13.0 && point.depth < 15.0) << point.x;
    }
    strokes = {};
    pen.draw(HatchStroke{{{60.0, 5.0}, {95.0, 5.0}}}, 1.0);
    EXPECT_TRUE(strokes.empty()) << "nothing is seen";
}

/// A ball of radius 40 in the middle of a wall.
Modalities ballBeforeWall() {
    Modalities made = halfSeen();
    made.extent = 80.0;
    for (std::uint32_t row = 0; row < penSide; ++row) {
        for (std::uint32_t column = 0; column < penSide; ++column) {
            const double from = std::hypot(column + 0.5 - 48.0, row + 0.5 - 48.0);
            made.depth.at(column, row) =
                from < 40.0 ? static_cast<float>(100.0 - std::sqrt(1600.0 - from * from)) : 140.0F;
        }
    }
    return made;
}

/// How far in front of what is seen each pixel of strokes' ways lies, at most and at least.
std::pair<double, double> inFront(const Strokes& strokes, const Modalities& modalities) {
    double least = HUGE_VAL, most = -HUGE_VAL;
    for (const auto& line : strokes.lines) {
        for (std::uint32_t i = line.begin; i + 1 < line.end; ++i) {
            const auto &from = strokes.points[i], &to = strokes.points[i + 1];
            for (double share = 0.0; share <= 1.0; share += 1.0 / 256) {
                const double depth = static_cast<double>(
                    modalities.depth.near(std::lerp(static_cast<double>(from.x), to.x, share),
                                          std::lerp(static_cast<double>(from.y), to.y, share)));
                const double off = depth - std::lerp(from.depth, to.depth, share);
                least = std::min(least, off);
                most = std::max(most, off);
            }
        }
    }
    return {least, most};
}

TEST(Pen, AHatchFollowsASurfaceThatBulges) {
    const auto modalities = ballBeforeWall();
    for (const double angle : {0.0, 0.3, 0.8, 1.5}) {
        const glm::dvec2 along(std::cos(angle), std::sin(angle));
        for (const double off : {-25.0, 0.0, 11.0}) {
            const glm::dvec2 middle = 48.0 + off * glm::dvec2(-along.y, along.x);
            Strokes strokes;
            Pen(modalities, {}, strokes)
                .draw(HatchStroke{{middle - 28.0 * along, middle + 28.0 * along}}, 1.0);
            const auto [least, most] = inFront(strokes, modalities);
            EXPECT_GT(least, 0.0);
            EXPECT_LT(most, 0.08 * modalities.extent);
        }
    }
    Strokes strokes;
    Pen(modalities, {}, strokes).draw(HatchStroke{{{2.0, 2.0}, {90.0, 3.0}}}, 1.0);
    EXPECT_EQ(strokes.points.size(), 2U) << "on a wall two places tell all";
}

TEST(Pen, ASilhouetteLiesInFrontOfWhatBulgesWithin) {
    const auto modalities = ballBeforeWall();
    InkLine circle{LineKind::silhouette, {}};
    for (int i = 0; i <= 64; ++i) {
        const double angle = i / 64.0 * 2.0 * std::numbers::pi;
        circle.points.push_back({48.0 + 40.0 * glm::dvec2(std::cos(angle), std::sin(angle)), 100.0, 1.0});
    }
    Strokes strokes;
    Pen(modalities, {}, strokes).draw(circle, 1.0);
    for (const auto& point : strokes.points) {
        double nearest = HUGE_VAL;
        for (const double x : {-1.0, 0.0, 1.0}) {
            for (const double y : {-1.0, 0.0, 1.0})
                nearest = std::min(
                    nearest, static_cast<double>(modalities.depth.near(static_cast<double>(point.x) + x,
                                                                       static_cast<double>(point.y) + y)));
        }
        EXPECT_LT(point.depth, nearest);
        EXPECT_GT(point.depth, 100.0 - 0.25 * modalities.extent);
    }
}

TEST(Pen, AHandSubdividesDepthEvenly) {
    const auto modalities = halfSeen();
    Strokes strokes;
    Pen pen(modalities, {.taper = true}, strokes);
    pen.draw(InkLine{LineKind::border, {{{0.0, 0.0}, 2.0}, {{80.0, 0.0}, 10.0}}}, 2.0);
    ASSERT_GT(strokes.points.size(), 10U);
    for (const auto& point : strokes.points) {
        EXPECT_NEAR(point.depth + 2e-3, 2.0 + static_cast<double>(point.x) / 10.0, 1e-6);
        EXPECT_LE(point.width, 2.0F);
    }
    EXPECT_NEAR(strokes.points.front().width, 0.5F, 1e-6F);
    EXPECT_NEAR(strokes.points.back().width, 0.5F, 1e-6F);
    EXPECT_NEAR(strokes.points[strokes.points.size() / 2].width, 2.0F, 1e-6F);
}

TEST(Pen, AWaverIsAsFarOffAsItIsSaid) {
    const auto modalities = halfSeen();
    for (const double waver : {0.5, 4.0}) {
        double squares = 0.0, count = 0.0, most = 0.0;
        for (int i = 0; i < 300; ++i) {
            Strokes strokes;
            Pen pen(modalities, {.waver = waver}, strokes);
            pen.draw(InkLine{LineKind::border, {{{0.0, i * 3.0}, 2.0}, {{400.0, i * 3.0}, 2.0}}}, 2.0);
            for (const auto& point : strokes.points) {
                const double off = static_cast<double>(point.y) - i * 3.0;
                squares += off * off;
                count += 1.0;
                most = std::max(most, std::abs(off));
            }
        }
        const double deviation = std::sqrt(squares / count);
        EXPECT_TRUE(deviation > 0.7 * waver && deviation < 1.05 * waver) << deviation;
        EXPECT_LE(most, std::sqrt(3.0) * waver + 1e-4);
    }
}

TEST(Pen, AStrokesHandChangesWithNoOther) {
    test::Random random(2);
    const auto modalities = halfSeen();
    const Hand hand{.waver = 2.0, .taper = true};
    std::vector<InkLine> lines;
    for (int i = 0; i < 20; ++i) lines.push_back(anyLine(random, 6, 100.0));
    Strokes all;
    Pen pen(modalities, hand, all);
    for (const auto& line : lines) pen.draw(line, 1.0);
    for (std::size_t i = 0; i < lines.size(); ++i) {
        Strokes alone;
        Pen(modalities, hand, alone).draw(lines[i], 1.0);
        const auto [begin, end] = all.lines[i];
        EXPECT_EQ(alone.points,
                  std::vector<StrokePoint>(all.points.begin() + begin, all.points.begin() + end));
    }
}

TEST(Pen, ExtremesStayFinite) {
    test::Random random(3);
    const auto modalities = halfSeen();
    for (const double waver : {0.0, 1e-9, 16.0}) {
        for (const bool taper : {false, true}) {
            for (const double width : {0.1, 64.0}) {
                Strokes strokes;
                Pen pen(modalities, {.waver = waver, .taper = taper}, strokes);
                for (const double far : {1e-12, 0.3, 1e3}) {
                    for (const std::size_t points : {2U, 3U, 20U})
                        pen.draw(anyLine(random, points, far), width);
                    pen.draw(HatchStroke{{{-far, 0.0}, {far, far}}}, width);
                }
                pen.draw(anyLine(random, 3, 1e7), width);
                pen.draw(InkLine{LineKind::border, {{{3.0, 3.0}, 2.0}, {{3.0, 3.0}, 2.0}}}, width);
                pen.draw(HatchStroke{{{3.0, 3.0}, {3.0, 3.0}}}, width);
                expectFinite(strokes);
                EXPECT_LT(strokes.points.size(), 50000U);
            }
        }
    }
}

TEST(Pen, FillsRegionsAtTheDepthsOfWhatIsSeen) {
    Modalities scene;
    scene.depth = Raster<float>(40, 30, HUGE_VALF);
    for (std::uint32_t row = 0; row < 30; ++row) {
        for (std::uint32_t column = 0; column < 20; ++column)
            scene.depth.at(column, row) = static_cast<float>(column < 10 ? 5.0 : 3.0);
    }
    scene.extent = 2.0;
    const auto ring = [](double radius) {
        std::vector<glm::dvec2> points;
        for (int i = 0; i < 32; ++i)
            points.push_back(15.0 + radius * glm::dvec2(std::cos(0.2 * i), std::sin(0.2 * i)));
        return points;
    };
    Strokes strokes;
    Pen pen(scene, {}, strokes);
    pen.fill({}, {});
    EXPECT_EQ(strokes, Strokes{});
    pen.fill({{ring(9.0), 4}, {ring(6.0), 4}, {ring(3.0), 7}}, {});
    ASSERT_EQ(strokes.areas.size(), 2U);
    EXPECT_EQ(strokes.areas[0], (InkArea{0, 2}));
    EXPECT_EQ(strokes.areas[1], (InkArea{2, 3}));
    ASSERT_EQ(strokes.outlines.size(), 3U);
    EXPECT_EQ(strokes.outlines[1], (Stroke{32, 64}));
    // A thousandth of the extent in front; beside a step as near as what is nearer.
    EXPECT_NEAR(strokes.areaDepths.at(8, 15), 4.998, 1e-5);
    EXPECT_NEAR(strokes.areaDepths.at(9, 15), 2.998, 1e-5);
    EXPECT_NEAR(strokes.areaDepths.at(39, 29), 2.998, 1e-5);
    EXPECT_EQ(strokes.areaDepths.at(40, 0), AreaDepths::none);
}

}  // namespace
}  // namespace mote::render
