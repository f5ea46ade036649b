// SPDX-License-Identifier: GPL-3.0-or-later
//
// Fields made in memory for tests of what ink sees of them. Pure.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "server/render/layers/ink/extinction_table.h"
#include "server/render/layers/ink/ink_data.h"
#include "server/render/layers/ink/lower_ink.h"
#include "server/render/layers/ink/volume_lines.h"
#include "server/render/layers/ink/volume_modalities.h"
#include "server/render/layers/ink/volume_rays.h"
#include "server/render/plan/frame_plan.h"
#include "tests/support/hybrid_scene.h"
#include "tests/support/random.h"
#include "tests/unit/ink/ink_views.h"

namespace mote::test {

/// [0, 1]^3 to [-1, 1]^3.
inline HybridShape cubeShape(std::uint32_t samples) {
    return {.source = glm::uvec3(samples), .low = glm::uvec3(samples), .boxToLayer = render::plotToLayer()};
}

/// `opacity` of values, over a length in layer units.
inline render::InkVolume inkVolume(const HybridShape& shape, std::vector<Curve::Knot> opacity, double length,
                                   const std::function<double(const glm::dvec3&)>& inLayer) {
    auto field = hybridOf(shape, [&](const glm::dvec3& inBox) {
        return inLayer(glm::dvec3(shape.boxToLayer * glm::dvec4(inBox, 1.0)));
    });
    return {std::move(field),
            {.opacity = Curve::create(std::move(opacity)).value(), .opacityLength = length}};
}

/// Along -z, with the middle in the middle; a pixel is 2 / pixels units.
inline Camera ahead(double height) {
    return {.eye = {0.0, 0.0, 5.0}, .target = glm::dvec3(0.0), .orthographicHeight = height};
}

/// A ball around the middle, opaque within a hundredth of its surface.
inline render::InkVolume ball(std::uint32_t samples, double radius,
                              const glm::dvec3& middle = {0.0, 0.0, 0.0}) {
    return inkVolume(cubeShape(samples), {{0.5, 0.0}, {0.51, 0.99}}, 0.01, [=](const glm::dvec3& at) {
        return std::clamp(0.5 + 0.5 * (radius - glm::length(at - middle)), 0.0, 1.0);
    });
}

}  // namespace mote::test

namespace mote::render {
namespace {

// Lines of scalar fields: the outline of a ball is its circle, and what lies in front of something else has
// an outline there.

constexpr std::uint32_t volumeSide = 100;
constexpr double pixel = 0.02;  // units

VolumeModalities seen(const InkVolume& volume) {
    return modalitiesOf(volume, glm::dmat4(1.0), test::usualInk(),
                        test::planOf(test::ahead(volumeSide * pixel), volumeSide, volumeSide), {});
}

/// From a place of the layer, in units.
double distanceTo(const LinePoint& point, double right, double up) {
    return std::hypot(point.at.x * pixel - 1.0 - right, 1.0 - point.at.y * pixel - up);
}

double lengthOf(const InkLine& line) {
    double length = 0.0;
    for (std::size_t i = 1; i < line.points.size(); ++i)
        length += glm::distance(line.points[i - 1].at, line.points[i].at);
    return length;
}

TEST(VolumeLines, OfABallAreItsCircle) {
    constexpr double radius = 0.7;
    const auto lines = linesOf(seen(test::ball(64, radius)), {});
    ASSERT_EQ(lines.size(), 1U);
    const auto& points = lines[0].points;
    EXPECT_EQ(points.front().at, points.back().at) << "closed";
    // A ray grows opaque within a hundredth of the radius; points are left out that lie within an eighth of
    // a pixel of the line.
    for (const auto& point : points) {
        EXPECT_NEAR(distanceTo(point, 0.0, 0.0), radius, 0.35 * pixel);
        EXPECT_EQ(point.step, 1.0);
        EXPECT_NEAR(point.depth, 5.0, 0.2) << "beside the middle";
    }
    EXPECT_NEAR(lengthOf(lines[0]) * pixel, 2.0 * 3.14159265 * radius, 0.03 * radius);
    EXPECT_LT(points.size(), 200U) << "of half pixels it has 440";
}

TEST(VolumeLines, PartWhatLiesBehindFromWhatLiesInFront) {
    constexpr double radius = 0.4;
    const glm::dvec3 front(0.2, 0.0, 0.5), back(-0.2, 0.0, -0.5);
    const auto both =
        test::inkVolume(test::cubeShape(64), {{0.5, 0.0}, {0.51, 0.99}}, 0.01, [&](const glm::dvec3& at) {
            const double nearest = std::min(glm::distance(at, front), glm::distance(at, back));
            return std::clamp(0.5 + 0.5 * (radius - nearest), 0.0, 1.0);
        });
    const auto lines = linesOf(seen(both), {});
    double inside = 0.0;
    for (const auto& line : lines) {
        for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
            const auto& point = line.points[i];
            const double toFront = distanceTo(point, front.x, front.y),
                         toBack = distanceTo(point, back.x, back.y);
            // Where the outlines meet, in a corner, a smooth line leaves them.
            EXPECT_LT(std::min(std::abs(toFront - radius), std::abs(toBack - radius)), 1.5 * pixel);
            if (toBack > radius - 2.0 * pixel) continue;
            EXPECT_NEAR(toFront, radius, 0.7 * pixel) << "nothing of what is hidden";
            // One unit between their middles, and so between places as far from them on the way.
            EXPECT_GT(point.step, 0.2);
            EXPECT_LT(point.step, 0.7);
            inside += glm::distance(point.at, line.points[i + 1].at) * pixel;
        }
    }
    // Of the front ball's circle, what lies in the other's: twice an angle of acos(0.2 / 0.4).
    EXPECT_NEAR(inside, 2.0 * std::acos(0.5) * radius, 0.1);
}

TEST(VolumeLines, AreNotWhereMatterIsThin) {
    const auto haze =
        test::inkVolume(test::cubeShape(16), {{0.0, 0.2}}, 1.0, [](const auto&) { return 0.5; });
    EXPECT_TRUE(linesOf(seen(haze), {}).empty());
}

// What ink sees of scalar fields, against closed forms: even matter, a ball, nothing at all.

const glm::dmat4 unmoved(1.0);

InkStyle styleOf(double ambient, double diffuse) {
    auto style = test::usualInk();
    style.light = {
        .direction = glm::normalize(glm::dvec3(-0.4, 0.6, 0.7)), .ambient = ambient, .diffuse = diffuse};
    return style;
}

/// Opacity 0.3 over a length of 1: what is left behind 2 units is 0.49.
TEST(VolumeModalities, OfEvenMatterAreThoseOfItsExtinction) {
    const auto volume =
        test::inkVolume(test::cubeShape(9), {{0.0, 0.3}}, 1.0, [](const auto&) { return 0.5; });
    for (const bool exact : {true, false}) {
        auto plan = test::planOf(test::ahead(1.0), 4, 3);
        plan.exact = exact;
        const auto seen = modalitiesOf(volume, unmoved, styleOf(0.25, 0.5), plan, {});
        const double extinction = -std::log(0.7), opacity = 1.0 - 0.49;
        const double half = -std::log(1.0 - 0.5 * opacity) / extinction;
        for (std::size_t i = 0; i < 12; ++i) {
            // Matter without a gradient is as light as can be.
            EXPECT_NEAR(static_cast<double>(seen.modalities.grey.values[i]), 0.75 * opacity + 0.49, 1e-5);
            // Within a part of a step, a twelfth of a light's loss, depths are taken to be even.
            EXPECT_NEAR(static_cast<double>(seen.modalities.depth.values[i]), 4.0 + half, 2e-3);
            EXPECT_EQ(seen.modalities.angle.values[i], 0.0F);
            EXPECT_EQ(seen.modalities.part.values[i], 0U);
        }
        EXPECT_NEAR(seen.modalities.extent, 2.0, 1e-12);
        EXPECT_EQ(seen.side, exact ? 2U : 1U);
        EXPECT_NEAR(static_cast<double>(seen.opacity.values[0]), opacity, 1e-6);
    }
}

TEST(VolumeModalities, OfABallAreThoseOfItsSurface) {
    constexpr double radius = 0.7, pixel = 2.0 / 64.0;
    const auto volume = test::ball(64, radius);
    const auto style = styleOf(0.2, 0.7);
    const auto plan = test::planOf(test::ahead(2.0), 64, 64);
    const auto seen = modalitiesOf(volume, unmoved, style, plan, {}).modalities;
    for (std::uint32_t y = 0; y < 64; ++y) {
        for (std::uint32_t x = 0; x < 64; ++x) {
            const double right = (x + 0.5) * pixel - 1.0, up = 1.0 - (y + 0.5) * pixel;
            const double off = std::hypot(right, up);
            if (off > radius + 2.0 * pixel) {
                EXPECT_EQ(seen.part.at(x, y), Modalities::nothing);
                EXPECT_EQ(seen.grey.at(x, y), 1.0F);
                EXPECT_FALSE(std::isfinite(seen.depth.at(x, y)));
            }
            if (off > 0.8 * radius) continue;
            const double front = std::sqrt(radius * radius - off * off);
            // Matter begins at the radius and hides what lies behind within two hundredths; a depth is that
            // of the nearest of four rays, a quarter of a pixel off, where the slope is at most 4/3.
            EXPECT_NEAR(static_cast<double>(seen.depth.at(x, y)), 5.0 - front, 0.02 + 0.48 * pixel);
            const glm::dvec3 normal = glm::dvec3(right, up, front) / radius;
            const double lit = 0.2 + 0.7 * std::max(0.0, glm::dot(normal, style.light.direction));
            EXPECT_NEAR(static_cast<double>(seen.grey.at(x, y)), lit, 0.03);
            // Where the normal lies well aslant, its angle is that of the place.
            if (off < 0.2) continue;
            const double turn = static_cast<double>(seen.angle.at(x, y)) - std::atan2(-up, right);
            EXPECT_NEAR(std::cos(turn), 1.0, 0.003) << x << ' ' << y;
        }
    }
}

TEST(VolumeModalities, AreWithinWhatCanBeSeen) {
    const auto seen =
        modalitiesOf(test::ball(64, 0.3), unmoved, test::usualInk(), test::planOf(test::ahead(2.0), 8, 8), {})
            .modalities;
    EXPECT_GT(seen.extent, 0.6);
    EXPECT_LT(seen.extent, 1.4) << "blocks of 8 samples are a quarter of a unit";
}

TEST(VolumeModalities, OfNothingArePaper) {
    const auto transparent = test::inkVolume(test::cubeShape(8), {{0.0, 0.0}}, 1.0,
                                             [](const auto& at) { return 0.5 + 0.5 * at.x; });
    const auto beyond = test::inkVolume(test::cubeShape(8), {{0.0, 0.0}, {0.9, 0.0}, {1.0, 1.0}}, 1.0,
                                        [](const auto&) { return 0.5; });
    for (const auto& volume : {transparent, beyond}) {
        for (const bool dark : {true, false}) {
            auto style = test::usualInk();
            style.inkIsDark = dark;
            const auto plan = test::planOf(test::ahead(2.0), 13, 7);
            const auto seen = modalitiesOf(volume, unmoved, style, plan, {}).modalities;
            EXPECT_EQ(seen.grey, Raster<float>(13, 7, dark ? 1.0F : 0.0F));
            EXPECT_EQ(seen.part, Raster<std::uint32_t>(13, 7, Modalities::nothing));
            const Layer layer{.dataset = "data/a", .style = proto::InkStyle()};
            EXPECT_TRUE(inkOf(layer, style, volume, plan, 1.0, {}).strokes.empty());
        }
    }
}

TEST(InkTransfer, ShowsASurfaceWithoutHazeUnlessACurveIsGiven) {
    const auto volume = test::ball(24, 0.7);
    for (const bool density : {true, false}) {
        auto style = test::usualInk();
        const auto transfer = inkTransfer(style, *volume.field, density);
        int haze = 0, solid = 0;
        for (int i = 0; i <= 1000; ++i) {
            const double opacity = transfer.opacity(i / 1000.0);
            haze += opacity > 0.0 && opacity < 0.95 ? 1 : 0;
            solid += opacity >= 0.95 ? 1 : 0;
        }
        EXPECT_LE(haze, 30) << density;
        EXPECT_GT(solid, 100) << density;
        style.opacity = Curve::create({{0.1, 0.0}, {0.9, 0.4}}).value();
        EXPECT_EQ(inkTransfer(style, *volume.field, density).opacity, *style.opacity);
    }
}

/// Grids of one sample a side, sheets, and boxes without an inverse.
TEST(VolumeModalities, HaveSomethingToSayOfAnyField) {
    test::Random random(5);
    for (int i = 0; i < 60; ++i) {
        test::HybridShape shape{.source = {1 + random.below(9), 1 + random.below(9), 1 + random.below(30)},
                                .low = {1 + random.below(4), 1 + random.below(4), 1 + random.below(4)},
                                .boxToLayer = plotToLayer(),
                                .threshold = random.chance(0.5) ? 0.1 : 0.0};
        if (random.chance(0.1)) shape.boxToLayer[2] = glm::dvec4(0.0);
        const double wave = random.between(0.0, 20.0), opacity = random.unit();
        const auto volume = test::inkVolume(
            shape, {{0.3, 0.0}, {random.between(0.3, 1.0), opacity}}, random.magnitude(-8, 2),
            [=](const auto& at) { return 0.5 + 0.5 * std::sin(wave * (at.x + at.y * at.z)); });
        const auto transform = test::anyTransform(random);
        const auto camera = test::anyCamera(random, Bounds(plotBounds).transformed(transform));
        const auto plan = test::planOf(camera, 1 + random.below(20), 1 + random.below(20));
        const auto seen = modalitiesOf(volume, transform, test::usualInk(), plan, {}).modalities;
        for (std::size_t k = 0; k < seen.grey.values.size(); ++k) {
            EXPECT_TRUE(seen.grey.values[k] >= 0.0F && seen.grey.values[k] <= 1.00001F);
            EXPECT_EQ(std::isfinite(seen.depth.values[k]), seen.part.values[k] == 0);
            EXPECT_TRUE(std::isfinite(seen.angle.values[k]));
        }
    }
}

/// Samples that show something and lie apart, so that each matters.
double grain(const glm::dvec3& at, double density) {
    const double hash = std::sin(glm::dot(at, glm::dvec3(127.1, 311.7, 74.7))) * 43758.5453;
    return hash - std::floor(hash) < density ? 1.0 : 0.0;
}

/// Rays that are followed only where something can be seen see the very same, in all pixels of a picture.
void expectTheSameBySpans(const InkVolume& volume, const glm::dmat4& transform, const FramePlan& plan,
                          int& seen, int& unseen) {
    VolumeRays rays(volume, transform, test::usualInk().light, plan);
    const VolumeRays everywhere(volume, transform, test::usualInk().light, plan);
    if (rays.any()) rays.findSpans();
    VolumeRays::Scratch scratch, other;
    for (std::uint32_t y = 0; y < plan.height; ++y) {
        for (std::uint32_t x = 0; x < plan.width; ++x) {
            const auto one = rays.look(x + 0.4, y + 0.6, 0.02, scratch),
                       two = everywhere.look(x + 0.4, y + 0.6, 0.02, other);
            EXPECT_EQ(one.opacity, two.opacity);
            EXPECT_EQ(one.depth, two.depth);
            EXPECT_EQ(one.light, two.light);
            EXPECT_EQ(one.normal, two.normal);
            EXPECT_EQ(VolumeRays::depthWhere(scratch, 0.01), VolumeRays::depthWhere(other, 0.01));
            ++(two.opacity > 0.0 ? seen : unseen);
        }
    }
}

/// Any fields, moved anywhere, from outside, near by and from within.
TEST(VolumeRays, SeeTheSameWhereSpansAreKnown) {
    test::Random random(21);
    int seen = 0, unseen = 0;
    for (int i = 0; i < 200; ++i) {
        test::HybridShape shape{.source = {1 + random.below(60), 1 + random.below(40), 1 + random.below(30)},
                                .low = {1 + random.below(9), 1 + random.below(9), 1 + random.below(9)},
                                .boxToLayer = plotToLayer(),
                                .threshold = 0.1};
        if (random.chance(0.05)) shape.boxToLayer[2] = glm::dvec4(0.0);
        const double density = random.magnitude(-13, 0), least = random.between(0.0, 0.6);
        const auto volume =
            test::inkVolume(shape, {{least, 0.0}, {least + 0.1, random.unit()}}, random.magnitude(-12, 2),
                            [=](const auto& at) { return grain(at, density); });
        const auto transform = test::anyTransform(random);
        auto camera = test::anyCamera(random, Bounds(plotBounds).transformed(transform));
        if (random.chance(0.3)) {
            const auto inside = [&] { return random.between(-1.0, 1.0); };
            camera.eye = glm::dvec3(transform * glm::dvec4(inside(), inside(), inside(), 1.0));
        }
        expectTheSameBySpans(volume, transform,
                             test::planOf(camera, 1 + random.below(40), 1 + random.below(40)), seen, unseen);
    }
    EXPECT_GT(seen, 10000);
    EXPECT_GT(unseen, 10000);
}

/// One grain in the last or the first samples of blocks, which stand straight before the eye: spans cover no
/// more than they have to.
TEST(VolumeRays, SeeTheSameAtTheBordersOfBlocks) {
    test::Random random(23);
    int seen = 0, unseen = 0;
    for (int i = 0; i < 40; ++i) {
        const auto border = [&] { return 8 * (1 + random.below(2)) - (random.chance(0.5) ? 1 : 0); };
        const glm::dvec3 at((glm::dvec3(border(), border(), border()) + 0.5) / 24.0);
        auto field = test::hybridOf(
            {.source = glm::uvec3(24), .low = glm::uvec3(6), .boxToLayer = plotToLayer(), .threshold = 0.01},
            [&](const auto& place) { return glm::distance(place, at) < 0.02 ? 1.0 : 0.0; });
        const InkVolume volume{field,
                               {.opacity = Curve::create({{0.05, 0.0}, {0.1, 0.9}}).value(),
                                .opacityLength = random.magnitude(-8, 0),
                                .span = {0.0, 1.0}}};
        expectTheSameBySpans(volume, unmoved, test::planOf(test::ahead(random.between(1.0, 3.0)), 150, 150),
                             seen, unseen);
    }
    EXPECT_GT(seen, 2000);
    EXPECT_GT(unseen, 2000);
}

/// Where a surface lies within a step of a sixth of a unit.
TEST(VolumeRays, TellDepthsWithinAStep) {
    test::Random random(22);
    for (int i = 0; i < 50; ++i) {
        const double surface = random.between(-0.7, 0.7);
        const auto volume = test::inkVolume(
            test::cubeShape(9), {{0.5, 0.0}, {0.51, 0.99}}, 0.01,
            [&](const auto& at) { return std::clamp(0.5 + 0.2 * (surface - at.z), 0.0, 1.0); });
        const VolumeRays rays(volume, unmoved, test::usualInk().light, test::planOf(test::ahead(1.0), 4, 4));
        VolumeRays::Scratch scratch;
        const auto seen = rays.look(1.3, 2.2, 0.02, scratch);
        // Matter grows opaque within a twentieth; so fine are parts of steps.
        EXPECT_NEAR(seen.depth, 5.0 - surface + 0.02, 0.02) << surface;
    }
}

TEST(VolumeModalities, AreTheSameOnAnyNumberOfThreadsAndEndWhereTheyAreToStop) {
    const auto volume =
        test::inkVolume(test::cubeShape(24), {{0.3, 0.0}, {1.0, 0.2}}, 0.1,
                        [](const auto& at) { return 0.5 + 0.5 * std::sin(9.0 * at.x + 5.0 * at.y * at.z); });
    const auto plan = test::planOf(test::ahead(2.5), 50, 40);
    tbb::task_arena one(1), more(4);
    VolumeModalities alone, together;
    one.execute([&] { alone = modalitiesOf(volume, unmoved, test::usualInk(), plan, {}); });
    more.execute([&] { together = modalitiesOf(volume, unmoved, test::usualInk(), plan, {}); });
    EXPECT_EQ(alone.modalities.grey, together.modalities.grey);
    EXPECT_EQ(alone.modalities.angle, together.modalities.angle);
    EXPECT_EQ(alone.depth, together.depth);
    std::stop_source stop;
    stop.request_stop();
    const auto stopped = modalitiesOf(volume, unmoved, test::usualInk(), plan, stop.get_token());
    EXPECT_EQ(stopped.modalities.part, Raster<std::uint32_t>(50, 40, Modalities::nothing));
}

// What rays through scalar fields are made of: extinction between samples, and the rims of surfaces.

TEST(ExtinctionTable, HoldsTheMeanBetweenTwoValues) {
    test::Random random(3);
    const test::HybridShape shape{.source = glm::uvec3(2), .low = glm::uvec3(2), .range = {-5.0, 3.0}};
    const auto field = test::hybridOf(shape, [](const auto&) { return 0.0; });
    const TransferFunction transfer{
        .opacity = Curve::create({{-2.0, 0.0}, {-1.0, 0.3}, {0.0, 0.1}, {2.0, 0.9}}, -10.0, 10.0).value(),
        .opacityLength = 0.5,
        .span = {-3.0, 2.5}};
    const ExtinctionTable table(*field, TransferTable(transfer));
    for (int i = 0; i < 200; ++i) {
        const double from = random.between(-5.0, 3.0), to = from + random.sign() * random.magnitude(-12, 2);
        double mean = 0.0;
        constexpr int parts = 4000;
        for (int k = 0; k < parts; ++k)
            mean += transfer.extinction(std::lerp(from, to, (k + 0.5) / parts)) / parts;
        const double told = table.mean(table.at(static_cast<float>(field->codeOf(from))),
                                       table.at(static_cast<float>(field->codeOf(to))));
        // A cell of the table is 5.5 / 4095 wide, where extinction changes by at most 12 a unit.
        EXPECT_NEAR(told, mean, 0.02) << from << ' ' << to;
    }
    const auto below = table.at(static_cast<float>(field->codeOf(-4.0)));
    EXPECT_EQ(table.mean(below, below + 1.0), 0.0);
}

TEST(ExtinctionTable, TellsTheMostOfARange) {
    test::Random random(4);
    const test::HybridShape shape{.source = glm::uvec3(2), .low = glm::uvec3(2), .range = {-5.0, 3.0}};
    const auto field = test::hybridOf(shape, [](const auto&) { return 0.0; });
    const TransferTable cells(
        {.opacity = Curve::create({{-2.0, 0.0}, {-1.0, 0.3}, {0.0, 0.1}, {2.0, 0.9}}, -10.0, 10.0).value(),
         .opacityLength = 0.5,
         .span = {-3.0, 2.5}});
    const ExtinctionTable table(*field, cells);
    for (int i = 0; i < 300; ++i) {
        const double low = random.between(-5.0, 3.0), high = low + random.magnitude(-12, 2);
        const auto cellOf = [&](double value) {
            const double at = (value - cells.low()) / (cells.high() - cells.low()) * TransferTable::cells;
            return static_cast<std::size_t>(std::clamp(at, 0.0, TransferTable::cells - 1.0));
        };
        double most = 0.0;
        for (std::size_t cell = cellOf(low); cell <= cellOf(high); ++cell)
            most = std::max(most, cells.ofCells()[cell].extinction);
        EXPECT_EQ(table.most(low, high), most) << low << ' ' << high;
    }
}

/// Against the mean of what lies before.
TEST(ExtinctionTable, TellsHowExtinctionIsSpreadBetweenTwoPlaces) {
    test::Random random(8);
    const test::HybridShape shape{.source = glm::uvec3(2), .low = glm::uvec3(2)};
    const auto field = test::hybridOf(shape, [](const auto&) { return 0.0; });
    const ExtinctionTable table(
        *field, TransferTable({.opacity = Curve::create({{0.2, 0.0}, {0.4, 0.9}, {0.7, 0.1}}).value(),
                               .opacityLength = 1.0,
                               .span = {0.0, 1.0}}));
    const double cells = TransferTable::cells;
    int uneven = 0;
    for (int i = 0; i < 300; ++i) {
        const double from = random.between(0.0, cells),
                     to = std::clamp(from + random.sign() * random.magnitude(-20, 11), 0.0, cells);
        const double all = table.mean(from, to);
        if (!(all > 0.0)) continue;
        const ExtinctionTable::Spread spread(table, from, to);
        const double way = random.unit();
        EXPECT_NEAR(spread(way), way * table.mean(from, std::lerp(from, to, way)) / all, 1e-6)
            << from << ' ' << to;
        uneven += std::abs(spread(way) - way) > 0.01 ? 1 : 0;
        EXPECT_EQ(spread(0.0), 0.0);
        EXPECT_NEAR(spread(1.0), 1.0, 1e-9);
    }
    EXPECT_GT(uneven, 25);
}

TEST(Rims, AreTheSteepBordersOfSurfaces) {
    Raster<float> sharp(64, 3), gentle(64, 3);
    for (std::uint32_t y = 0; y < 3; ++y) {
        for (std::uint32_t x = 0; x < 64; ++x) {
            sharp.at(x, y) = static_cast<float>(std::clamp(1.0 - (x - 4.2) / 6.0, 0.0, 1.0));
            gentle.at(x, y) = static_cast<float>(std::max(0.6 - 0.01 * x, 0.0));
        }
    }
    const auto rims = rimsOf(sharp), none = rimsOf(gentle);
    for (std::uint32_t x = 0; x < 64; ++x) {
        // It falls by a sixth a pixel, from one half on at 7; from 20 pixels on all is far away.
        EXPECT_EQ(rims.at(x, 1), x > 7 && x < 27 ? 1 : 0) << x;
        EXPECT_EQ(none.at(x, 1), 0) << x << ": a hundredth a pixel";
    }
    EXPECT_EQ(rimsOf(Raster<float>(3, 2, 0.4F)), Raster<std::uint8_t>(3, 2)) << "beside no surface";
}

}  // namespace
}  // namespace mote::render
