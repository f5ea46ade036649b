// SPDX-License-Identifier: GPL-3.0-or-later
//
// Watercolour: where its layers lie, what they make of the paper, and that painted regions are drawn as they
// are said to be.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "protocol/scene/srgb.h"
#include "server/render/ink/drawing.h"
#include "server/render/ink/paint/mask.h"
#include "server/render/ink/paint/painting.h"
#include "server/render/ink/paint/wash.h"
#include "tests/support/random.h"
#include "tests/unit/ink/ink_views.h"

namespace mote::render {
namespace {

Raster<std::uint8_t> anyMask(test::Random& random, std::uint32_t width, std::uint32_t height, double share) {
    Raster<std::uint8_t> mask(width, height);
    for (auto& one : mask.values) one = random.chance(share) ? 1 : 0;
    return mask;
}

TEST(Mask, DistancesAreThoseToTheNearestMark) {
    test::Random random(1);
    for (int i = 0; i < 40; ++i) {
        const auto width = static_cast<std::uint32_t>(1 + random.below(90)),
                   height = static_cast<std::uint32_t>(1 + random.below(40));
        const auto mask = anyMask(random, width, height, random.oneOf({0.0, 0.001, 0.02, 0.5, 1.0}));
        const double most = random.oneOf({1.5, 7.0, 1000.0});
        const auto distance = distanceTo(mask, most);
        for (std::uint32_t at = 0; at < width * height; ++at) {
            double least = most;
            for (std::uint32_t other = 0; other < width * height; ++other) {
                if (mask.values[other] == 0) continue;
                least = std::min(least, std::hypot(double(at % width) - double(other % width),
                                                   double(at / width) - double(other / width)));
            }
            EXPECT_NEAR(static_cast<double>(distance.values[at]), least, 1e-4) << i << ' ' << at;
        }
    }
}

constexpr std::uint32_t side = 160;

/// A plane at depth 4 that faces the eye in a square of the picture's middle, and what it wants.
struct Square {
    InkScene scene;

    explicit Square(float grey = 0.5F) {
        auto& seen = scene.modalities;
        seen.grey = Raster<float>(side, side, 1.0F);
        seen.depth = Raster<float>(side, side, HUGE_VALF);
        seen.angle = Raster<float>(side, side);
        seen.part = Raster<std::uint32_t>(side, side, Modalities::nothing);
        seen.across = Raster<float>(side, side);
        for (std::uint32_t row = 30; row < 130; ++row) {
            for (std::uint32_t column = 30; column < 130; ++column) {
                seen.grey.at(column, row) = grey;
                seen.depth.at(column, row) = 4.0F;
                seen.part.at(column, row) = 0;
            }
        }
        scene.camera = {
            .toEye = glm::dmat4(1.0), .perspective = false, .pixels = side / 2.0, .size = {side, side}};
    }
};

/// Nothing but what is asked for.
InkStyle washStyle() {
    auto style = test::usualInk();
    style.silhouettes.mode = SilhouetteMode::none;
    style.hatch.strength = 0.0;
    style.wash.everywhere = true;
    style.wash.strength = 1.0;
    style.wash.edges = style.wash.granulation = 0.0;
    style.wash.bleed = 0.0;
    return style;
}

float pigmentIn(const Drawing& drawing, std::uint32_t column, std::uint32_t row) {
    return drawing.pigment.values.empty() ? 0.0F : drawing.pigment.at(column, row);
}

/// Without what water does, a wash is flat: so many layers as the tone asks for, and none beside it.
TEST(Wash, IsFlatAndAsDarkAsTheTone) {
    for (const int tones : {1, 2, 3, 8}) {
        auto style = washStyle();
        style.wash.tones = tones;
        float before = 0.0F;
        for (const float grey : {0.99F, 0.8F, 0.6F, 0.4F, 0.2F, 0.05F}) {
            const auto drawing = drawInk(Square(grey).scene, style, 1.0, {});
            const float pigment = pigmentIn(drawing, 80, 80);
            for (const std::uint32_t at : {50U, 60U, 100U})
                EXPECT_FLOAT_EQ(pigmentIn(drawing, at, 70), pigment);
            EXPECT_EQ(pigmentIn(drawing, 10, 80), 0.0F);
            // Whole layers, the more the darker; at most one too many or too few for the lightness.
            const float layers = pigment * static_cast<float>(tones);
            EXPECT_NEAR(layers, std::round(layers), 1e-4F);
            EXPECT_GE(pigment, before);
            before = pigment;
            const auto lightness = [](double luminance) { return std::cbrt(luminance); };
            const double wanted = std::max(lightness(double(grey)), lightness(luminance(style.wash.color)));
            const auto whole = static_cast<std::uint8_t>(std::lround(layers));
            const double drawn = lightness(1.0 - washCover(whole, style.wash, true));
            const double step = lightness(1.0) - lightness(1.0 - washCover(1, style.wash, true));
            EXPECT_LT(std::abs(drawn - wanted), step) << tones << ' ' << grey;
        }
        EXPECT_GT(before, 0.4F);
    }
}

TEST(Wash, GathersAtItsEdgesAndRunsOverThem) {
    auto style = washStyle();
    const auto sumOf = [](const Drawing& drawing, std::uint32_t from, std::uint32_t to) {
        double sum = 0.0;
        for (std::uint32_t row = 50; row < 110; ++row) {
            for (std::uint32_t column = from; column < to; ++column)
                sum += static_cast<double>(pigmentIn(drawing, column, row));
        }
        return sum / (60.0 * (to - from));
    };
    const Square square;
    const auto plain = drawInk(square.scene, style, 1.0, {});
    EXPECT_EQ(sumOf(plain, 20, 28), 0.0);
    style.wash.edges = 1.0;
    const auto dark = drawInk(square.scene, style, 1.0, {});
    EXPECT_GT(sumOf(dark, 31, 33), 1.2 * sumOf(plain, 31, 33));
    EXPECT_LT(sumOf(dark, 40, 44), sumOf(plain, 40, 44));
    style.wash.edges = 0.0;
    style.wash.bleed = 8.0;
    const auto wet = drawInk(square.scene, style, 1.0, {});
    EXPECT_GT(sumOf(wet, 22, 29), 0.0);
    EXPECT_EQ(sumOf(wet, 0, 14), 0.0);
    style.wash.bleed = 0.0;
    style.wash.granulation = 1.0;
    const auto grained = drawInk(square.scene, style, 1.0, {});
    // The square is not larger than the noise by which pigment is laid unevenly.
    EXPECT_NEAR(sumOf(grained, 40, 120), sumOf(plain, 40, 120), 0.8 * sumOf(plain, 40, 120));
    std::size_t same = 0;
    for (std::uint32_t i = 50; i < 110; ++i)
        same += pigmentIn(grained, i, 80) == pigmentIn(grained, i + 1, 80);
    EXPECT_LT(same, 3U);
}

/// What lies on the paper looks as pigment does that light passes; on dark paper it covers.
TEST(Wash, LetsThePaperThrough) {
    test::Random random(4);
    const auto anyColor = [&] { return glm::dvec3(random.unit(), random.unit(), random.unit()); };
    for (int i = 0; i < 200; ++i) {
        WashStyle style = washStyle().wash;
        style.color = anyColor();
        const glm::dvec3 paper = anyColor();
        const double pigment = random.between(0.01, 2.0);
        const auto on = onPaper(static_cast<float>(pigment), style, true, paper);
        if (!on) continue;
        ASSERT_TRUE(on->opacity > 0.0F && on->opacity <= 1.0F);
        const glm::dvec3 seen = glm::mix(paper, glm::dvec3(on->color), static_cast<double>(on->opacity));
        for (int c = 0; c < 3; ++c) {
            EXPECT_GE(on->color[c], 0.0F);
            EXPECT_NEAR(seen[c], paper[c] * std::pow(std::max(style.color[c], 1e-6), pigment), 1e-5);
        }
        const auto gouache = onPaper(static_cast<float>(pigment), style, false, paper);
        ASSERT_TRUE(gouache);
        EXPECT_EQ(gouache->color, glm::vec3(style.color));
    }
    EXPECT_FALSE(onPaper(0.0F, washStyle().wash, true, glm::dvec3(1.0)));
    EXPECT_FALSE(onPaper(0.0F, washStyle().wash, false, glm::dvec3(0.0)));
}

TEST(Wash, ThreadsChangeNothingAndAStopIsHeard) {
    auto style = test::usualInk();
    style.wash.everywhere = true;
    const Square square;
    tbb::task_arena one(1), more(2);
    Drawing alone, together;
    one.execute([&] { alone = drawInk(square.scene, style, 1.0, {}); });
    more.execute([&] { together = drawInk(square.scene, style, 1.0, {}); });
    ASSERT_FALSE(alone.pigment.values.empty());
    EXPECT_EQ(alone.pigment, together.pigment);
    EXPECT_EQ(alone.strokes, together.strokes);
    std::stop_source source;
    source.request_stop();
    EXPECT_TRUE(drawInk(square.scene, style, 1.0, source.get_token()).pigment.values.empty());
}

/// Hatches make up what the wash leaves.
TEST(Wash, LeavesLessToHatch) {
    auto style = test::usualInk();
    const auto inkOf = [&] {
        double sum = 0.0;
        const auto cover = test::coverOf(drawInk(Square(0.4F).scene, style, 1.0, {}).strokes, side, side);
        for (const double one : cover.values) sum += one;
        return sum;
    };
    const double all = inkOf();
    style.wash.everywhere = true;
    style.wash.strength = 1.0;
    EXPECT_LT(inkOf(), 0.6 * all);
}

// Regions painted by hand.

PaintedRegion dab(const glm::dvec2& pixel, double radius, RegionFill fill, bool whole = false) {
    // The camera of Square: 80 pixels a unit, depth 4.
    const glm::dvec3 place((pixel.x - 80.0) / 80.0, (80.0 - pixel.y) / 80.0, -4.0);
    return {
        .dabs = {place}, .radius = radius / 80.0, .whole = whole, .fill = fill, .direction = std::nullopt};
}

double inkIn(const Strokes& strokes, std::uint32_t left, std::uint32_t right) {
    const auto cover = test::coverOf(strokes, side, side);
    double sum = 0.0;
    for (std::uint32_t row = 70; row < 90; ++row) {
        for (std::uint32_t column = left; column < right; ++column) sum += cover.at(column, row);
    }
    return sum / (20.0 * (right - left));
}

TEST(Painting, PixelsBelongToTheLastDabThatTheySee) {
    test::Random random(6);
    for (int i = 0; i < 20; ++i) {
        Square square;
        auto& camera = square.scene.camera;
        const auto layer = test::anyTransform(random);
        camera.toEye = layer;
        camera.perspective = random.chance(0.5);
        const glm::dmat4 toLayer = glm::inverse(layer);
        const double scale = std::cbrt(std::abs(glm::determinant(glm::dmat3(toLayer))));
        std::vector<PaintedRegion> regions(3);
        for (auto& region : regions) {
            region = {.dabs = {},
                      .radius = scale * random.between(0.02, 0.5),
                      .whole = false,
                      .fill = random.oneOf({RegionFill::none, RegionFill::wash, RegionFill::usual}),
                      .direction = std::nullopt};
            for (int n = 0; n < 30; ++n) {
                const glm::dvec3 inEye = camera.inEye(
                    {{random.between(20.0, 140.0), random.between(20.0, 140.0)}, random.between(3.8, 4.2)});
                region.dabs.emplace_back(toLayer * glm::dvec4(inEye, 1.0));
            }
        }
        Segments none;
        const Painting painting(square.scene.modalities, camera, regions, none, {});
        EXPECT_TRUE(none.label.values.empty());
        for (std::uint32_t at = 0; at < side * side; at += 7) {
            auto fill = RegionFill::usual;
            const auto depth = square.scene.modalities.depth.values[at];
            bool near = false;
            for (const auto& region : regions) {
                for (const auto& one : region.dabs) {
                    if (!std::isfinite(depth)) continue;
                    const glm::dvec3 inEye =
                        camera.inEye({{at % side + 0.5, at / side + 0.5}, double(depth)});
                    const double away = glm::distance(glm::dvec3(toLayer * glm::dvec4(inEye, 1.0)), one);
                    near = near || std::abs(away / region.radius - 1.0) < 1e-6;
                    if (away <= region.radius) fill = region.fill;
                }
            }
            if (near) continue;
            EXPECT_EQ(painting.fillAt(at), fill) << i << ' ' << at;
        }
    }
}

TEST(Painting, EachFillIsDrawn) {
    const Square square(0.4F);
    auto style = test::usualInk();
    style.silhouettes.mode = SilhouetteMode::none;
    const auto draw = [&](RegionFill fill, bool whole = false) {
        style.regions = {dab({60.0, 80.0}, 22.0, fill, whole)};
        return drawInk(square.scene, style, 1.0, {});
    };
    // 45 to 75 is painted, 90 to 120 is not.
    const auto usual = draw(RegionFill::usual);
    const double hatched = inkIn(usual.strokes, 90, 120);
    EXPECT_GT(hatched, 0.3);
    EXPECT_NEAR(inkIn(usual.strokes, 45, 75), hatched, 0.3 * hatched);
    const auto bare = draw(RegionFill::none);
    EXPECT_LT(inkIn(bare.strokes, 45, 75), 0.02);
    EXPECT_NEAR(inkIn(bare.strokes, 90, 120), hatched, 0.3 * hatched);
    EXPECT_LT(inkIn(draw(RegionFill::none, true).strokes, 90, 120), 0.02) << "all of its region";
    const auto inked = draw(RegionFill::ink);
    EXPECT_GT(inkIn(inked.strokes, 45, 75), 0.99);
    EXPECT_NEAR(inkIn(inked.strokes, 90, 120), hatched, 0.3 * hatched);
    EXPECT_FALSE(inked.strokes.areas.empty());
    const auto washed = draw(RegionFill::wash);
    EXPECT_LT(inkIn(washed.strokes, 45, 75), 0.02);
    EXPECT_GT(pigmentIn(washed, 60, 80), 0.2F);
    EXPECT_EQ(pigmentIn(washed, 105, 80), 0.0F);
    style.wash.everywhere = true;
    const auto left = draw(RegionFill::hatch);
    EXPECT_EQ(pigmentIn(left, 60, 80), 0.0F);
    EXPECT_GT(pigmentIn(left, 105, 80), 0.2F);
    EXPECT_NEAR(inkIn(left.strokes, 45, 75), hatched, 0.3 * hatched);
    style.wash.everywhere = false;
    style.hatch.strength = 0.0;
    EXPECT_GT(inkIn(draw(RegionFill::hatch).strokes, 45, 75), 0.7 * hatched);
    EXPECT_EQ(inkIn(draw(RegionFill::hatch).strokes, 90, 120), 0.0);
}

TEST(Painting, HatchesGoWhereTheyAreTold) {
    const Square square(0.75F);  // for one direction of strokes
    auto style = test::usualInk();
    style.silhouettes.mode = SilhouetteMode::none;
    for (const double degrees : {0.0, 30.0, 90.0, -60.0, 135.0}) {
        auto region = dab({80.0, 80.0}, 40.0, RegionFill::usual);
        region.direction = degrees;
        style.regions = {region};
        const auto strokes = drawInk(square.scene, style, 1.0, {}).strokes;
        const glm::dvec2 told(std::cos(degrees * std::numbers::pi / 180.0),
                              -std::sin(degrees * std::numbers::pi / 180.0));
        double along = 0.0, all = 0.0;
        for (const auto& line : strokes.lines) {
            for (auto i = line.begin; i + 1 < line.end; ++i) {
                const auto &a = strokes.points[i], &b = strokes.points[i + 1];
                const glm::dvec2 from(a.x, a.y), way = glm::dvec2(b.x, b.y) - from;
                if (glm::distance(from, glm::dvec2(80.0)) > 30.0) continue;
                along += std::abs(glm::dot(way, told));
                all += glm::length(way);
            }
        }
        EXPECT_GT(all, 100.0);
        EXPECT_GT(along, 0.98 * all) << degrees;
    }
}

}  // namespace
}  // namespace mote::render
