// SPDX-License-Identifier: GPL-3.0-or-later
//
// Points that are drawn where they stand, and the edges of discs, against docs/PICTURE.md.
#include "server/render/cpu/point_footprint.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "protocol/scene/srgb.h"
#include "server/render/cpu/cpu_device.h"
#include "server/render/layers/make_frame_plan.h"
#include "tests/reference/scene_styles.h"
#include "tests/support/memory_step.h"
#include "tests/support/view_text.h"

namespace mote::render {
namespace {

using Points = std::vector<test::WeightedPoint>;

/// Seen along -z, as wide and high as the box. Nothing shows of the volume.
Scene sceneOf(const std::string& size, const std::string& points, const std::vector<Points>& layers) {
    const std::string layer =
        "{'particles': {'volume': {'curve': [{'density': 0, 'opacity': 0}]}, 'points': {" + points + "}}}";
    std::string text = "{" + size +
                       ", 'camera': {'eye': [0, 0, 3], 'target': [0, 0, 0], 'orthographicHeight': 2},"
                       "'layers': [";
    for (std::size_t i = 0; i < layers.size(); ++i) text += (i > 0 ? "," : "") + layer;
    Scene scene{test::viewOf(text + "]}"), {}};
    for (const auto& own : layers)
        scene.layers.push_back({.step = test::MemoryStep::make(own, {.volumeLevel = 0, .volume = {0.0F}})});
    return scene;
}

std::vector<std::uint8_t> draw(const Scene& scene) {
    CpuDevice device({.threads = 1});
    return device.render(makeFramePlan(scene, Quality::exact()), PixelFormat::srgb8, {})->pixels;
}

TEST(LonePoints, OfTwoLayersInOneSlabTheNearestHidesTheOthers) {
    // All in the 97th of 192 slabs, and at the same depth on average.
    const Points around{{{0.5, 0.5, 0.4990}}, {{0.5, 0.5, 0.4960}}};
    const Points between{{{0.5, 0.5, 0.4980}}, {{0.5, 0.5, 0.4970}}};
    for (const std::string size : {"1", "3"}) {
        auto scene =
            sceneOf("'width': 1, 'height': 1", "'opacity': 1, 'sizePixels': " + size, {around, between});
        test::particlesIn(scene, 0).pointColor = {1.0, 0.0, 0.0};
        test::particlesIn(scene, 1).pointColor = {0.0, 1.0, 0.0};
        const auto pixel = draw(scene);
        EXPECT_EQ(pixel[0], 255) << size;
        EXPECT_LE(pixel[1], 1) << size;
    }
}

TEST(LonePoints, AreFewAndAtRest) {
    const auto planOf = [](const std::string& look, std::size_t count, const Quality& quality) {
        Points points;
        for (std::size_t i = 0; i < count; ++i)
            points.push_back({{0.5 * i / count, std::fmod(0.618034 * i, 1.0), 0.5}});
        return makeFramePlan(sceneOf("'width': 64, 'height': 64", look, {points}), quality);
    };
    const auto alone = [&](const std::string& look, std::size_t count, const Quality& quality) {
        const auto plan = planOf(look, count, quality);
        return standAlone(plan, plan.points[0]);
    };
    const std::string pixels = "'opacity': 0.5, 'sizePixels': 1", clear = "'opacity': 0.01, 'sizePixels': 1";
    EXPECT_TRUE(alone(pixels, 16000, Quality::exact()));
    EXPECT_FALSE(alone(pixels, 17000, Quality::exact()));
    EXPECT_FALSE(alone(pixels, 100, {.slabs = 24}));
    EXPECT_TRUE(alone(clear, 1000, Quality::exact()));
    EXPECT_FALSE(alone(clear, 1100, Quality::exact()));
    // Discs that cover the tile: what lies behind opaque ones takes no memory.
    EXPECT_TRUE(alone("'opacity': 0.5, 'sizePixels': 64", 16000, Quality::exact()));
    EXPECT_FALSE(alone("'opacity': 0.017, 'sizePixels': 64", 16000, Quality::exact()));
}

TEST(LonePoints, EdgesOfOpaqueDiscsAreAsDefined) {
    constexpr double opacity = 0.9999;
    for (int tenths = 30; tenths < 40; ++tenths) {
        const Points one{{{0.53, 0.52, 0.5}}};
        const double size = tenths / 10.0;
        const auto picture =
            draw(sceneOf("'width': 8, 'height': 8, 'background': [0, 0, 0]",
                         "'opacity': 1, 'color': [1, 1, 1], 'sizePixels': " + std::to_string(size), {one}));
        for (int i = 0; i < 64; ++i) {
            const double dx = i % 8 + 0.5 - 8 * 0.53, dy = i / 8 + 0.5 - 8 * 0.48;
            const double coverage = std::clamp(0.5 * size + 0.5 - std::hypot(dx, dy), 0.0, 1.0);
            const double expected = 255.0 * linearToSrgb(opacity * coverage);
            // Coverage is told in 1024 steps, optical depth in 512 a unit: in the darkest tone they are worth
            // 3.2 and 6.4 steps of 255.
            EXPECT_NEAR(picture[4 * static_cast<std::size_t>(i)], expected, 0.5 * (3.2 + 6.4 + 1.0))
                << size << ' ' << i;
        }
    }
}

/// Points where they stand, in motion and alone in the picture: all by other ways (docs/PICTURE.md, "Layers
/// that fade").
TEST(LonePoints, OfALayerThatFadesHideInProportionInEachPixel) {
    const Points one{{{0.53, 0.52, 0.5}}}, behind{{{0.1, 0.1, 0.4}}};
    const auto drawn = [](const Scene& scene, const Quality& quality) {
        CpuDevice device({.threads = 1});
        return device.render(makeFramePlan(scene, quality), PixelFormat::srgb8, {})->pixels;
    };
    for (const std::string size : {"0.7", "1", "3.3"}) {
        for (const double opacity : {1.0, 0.8, 0.1}) {
            auto scene = sceneOf(
                "'width': 8, 'height': 8, 'background': [0, 0, 0]",
                "'color': [1, 1, 1], 'opacity': " + std::to_string(opacity) + ", 'sizePixels': " + size,
                {one, behind});
            for (const double w : {1.0, 0.6, 0.05}) {
                scene.view.layers[0].opacity = w;
                const double pixels = std::stod(size), most = std::min(opacity, 0.9999);
                const auto expected = [&](int i) {
                    const double dx = i % 8 + 0.5 - 8 * 0.53, dy = i / 8 + 0.5 - 8 * 0.48;
                    double coverage = std::clamp(0.5 * pixels + 0.5 - std::hypot(dx, dy), 0.0, 1.0);
                    if (pixels <= 1.0) coverage = i == 8 * 3 + 4 ? pixels * pixels : 0.0;
                    return 255.0 * linearToSrgb(1.0 - std::pow(1.0 - most * coverage, w));
                };
                for (const auto& quality : {Quality::exact(), Quality{.slabs = 24}}) {
                    const auto both = drawn(scene, quality);
                    Scene single{scene.view, {scene.layers[0]}};
                    single.view.layers.pop_back();
                    const auto alone = drawn(single, quality);
                    for (int i = 0; i < 64; ++i) {
                        const auto at = 4 * static_cast<std::size_t>(i);
                        EXPECT_NEAR(alone[at], expected(i), 5.5) << size << ' ' << opacity << ' ' << w;
                        // The other one is in the lower left corner.
                        if (i % 8 < 4 || i / 8 > 4) continue;
                        EXPECT_NEAR(both[at], expected(i), 5.5) << size << ' ' << opacity << ' ' << w;
                    }
                }
            }
        }
    }
}

}  // namespace
}  // namespace mote::render
