// SPDX-License-Identifier: GPL-3.0-or-later
//
// What ink sees of scalar fields, against closed forms: even matter, a ball, nothing at all.
#include "server/render/layers/ink/volume_modalities.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "server/render/layers/ink/lower_ink.h"
#include "tests/unit/ink/ink_views.h"
#include "tests/unit/ink/volume_scenes.h"

namespace mote::render {
namespace {

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

}  // namespace
}  // namespace mote::render
