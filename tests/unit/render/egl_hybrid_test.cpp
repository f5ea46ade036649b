// SPDX-License-Identifier: GPL-3.0-or-later
//
// The egl device's own ways with hybrid volumes: bands, passes, and what it keeps between pictures. That its
// pictures are right, tests/golden shows.
#include <gtest/gtest.h>

#include "server/render/egl/egl_device.h"
#include "server/render/layers/make_frame_plan.h"
#include "tests/support/hybrid_scene.h"
#include "tests/support/view_text.h"

namespace mote::render {
namespace {

std::shared_ptr<const GridField> machine() {
    static const auto step = test::hybridOf(
        {.source = {32, 24, 20}, .low = {8, 6, 5}, .threshold = 0.05, .parts = HybridRepresentation::points},
        test::machineParts);
    return step;
}

const std::string curve = "'curve': [{'value': 0.2, 'opacity': 0}, {'value': 1, 'opacity': 0.6}]";
const std::string otherCurve = "'curve': [{'value': 0.5, 'opacity': 0}, {'value': 0.7, 'opacity': 0.9}]";

std::string layer(const std::string& representation, const std::string& look = curve) {
    return "{'hybrid': {'representation': '" + representation + "', " + look + "}}";
}

Scene sceneOf(const std::string& layers, std::shared_ptr<const GridField> step = machine()) {
    Scene scene{test::viewOf("{'width': 131, 'height': 83, 'camera': {'eye': [1.5, 1.2, 2.2], 'target': "
                             "[0.5, 0.5, 0.5], 'fovYDegrees': 35}, 'layers': [" +
                             layers + "]}"),
                {}};
    scene.layers.assign(scene.view.layers.size(), {.hybrid = std::move(step)});
    return scene;
}

Picture picture(EglDevice& device, const Scene& scene) {
    return device.render(makeFramePlan(scene, Quality::exact()), PixelFormat::srgb8, {}).value();
}

TEST(EglHybrid, ThePictureIsTheSameInBandsAndPasses) {
    for (const auto& layers : {layer("points"), layer("points") + ',' + layer("volume")}) {
        const auto scene = sceneOf(layers);
        EglDevice whole;
        const auto expected = picture(whole, scene);
        EglOptions small;
        small.maskBytes = 1;  // a band holds one row of tiles at least
        small.cellBytes = 1;  // and a pass a few cells
        EglDevice pieces(small);
        EXPECT_EQ(picture(pieces, scene).pixels, expected.pixels) << layers;
        EXPECT_EQ(pieces.lastTimes().bands, (scene.view.height + 7) / 8);
    }
}

TEST(EglHybrid, WhatWasDrawnBeforeDoesNotMatter) {
    EglDevice device;
    std::vector<std::string> views;
    for (const char* representation : {"volume", "residual", "points"}) {
        views.push_back(layer(representation));
        views.push_back(layer(representation, otherCurve));
        views.push_back(layer(representation, curve + ", 'light': {'direction': [1, 0, 0]}"));
    }
    for (const char* look : {", 'pointOpacity': 0.5", ", 'pointShape': 'square'", ", 'pointShape': 'disc'"})
        views.push_back(layer("points", curve + look));
    std::vector<Picture> fresh;
    for (const auto& view : views) {
        EglDevice own;
        fresh.push_back(picture(own, sceneOf(view)));
    }
    for (std::size_t i = 0; i < views.size(); ++i) {
        EXPECT_EQ(picture(device, sceneOf(views[i])).pixels, fresh[i].pixels) << views[i];
        EXPECT_NE(fresh[i].pixels, fresh[(i + 1) % views.size()].pixels) << views[i];
    }
}

TEST(EglHybrid, TwoLayersOfOneVolumeHaveTheirOwnLooks) {
    // Far apart, so that each shows as it does alone.
    const std::string moved =
        "{'transform': [1, 0, 0, 0,  0, 1, 0, 1.1,  0, 0, 1, 0,  0, 0, 0, 1], 'hybrid': "
        "{'representation': 'points', " +
        otherCurve + "}}";
    EglDevice device;
    const auto both = picture(device, sceneOf(layer("points") + ',' + moved));
    const auto swapped = picture(device, sceneOf(moved + ',' + layer("points")));
    EXPECT_EQ(both.pixels, swapped.pixels);
    EXPECT_NE(both.pixels, picture(device, sceneOf(layer("points"))).pixels);
    EXPECT_NE(both.pixels, picture(device, sceneOf(moved)).pixels);
}

TEST(EglHybrid, StepsThatAreGoneAreLetGo) {
    EglDevice device;
    const auto make = [](double threshold) {
        return test::hybridOf({.source = {16, 16, 16}, .low = {4, 4, 4}, .threshold = threshold},
                              test::machineParts);
    };
    for (const double threshold : {0.0, 0.1, 0.2}) {
        const auto step = make(threshold);
        EglDevice own;
        EXPECT_EQ(picture(device, sceneOf(layer("residual"), step)).pixels,
                  picture(own, sceneOf(layer("residual"), step)).pixels);
        device.trim();
    }
    device.trim();
    EXPECT_FALSE(picture(device, sceneOf(layer("residual"))).pixels.empty());
}

TEST(EglHybrid, GridsOfOneSampleAndInvisibleCurvesAreDrawn) {
    EglDevice device;
    const auto flat = test::hybridOf({.source = {9, 1, 17}, .low = {3, 1, 1}}, test::machineParts);
    for (const char* representation : {"volume", "residual", "points"}) {
        EXPECT_FALSE(picture(device, sceneOf(layer(representation), flat)).pixels.empty());
        const auto nothing = picture(device, sceneOf(layer(representation, "'curve': [{'value': 0}]"), flat));
        for (std::size_t i = 0; i < nothing.pixels.size(); ++i)
            ASSERT_EQ(nothing.pixels[i], i % 4 == 3 ? 255 : 0);
    }
}

bool black(const Picture& picture) {
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
        if (i % 4 != 3 && picture.pixels[i] != 0) return false;
    }
    return true;
}

TEST(EglHybrid, PointsShowWhereTheirVolumeDoesNot) {
    EglDevice device;
    const std::string sharp = "'curve': [{'value': 0.7, 'opacity': 0}, {'value': 0.9, 'opacity': 0.9}]";
    ASSERT_TRUE(black(picture(device, sceneOf(layer("volume", sharp)))));
    EXPECT_FALSE(black(picture(device, sceneOf(layer("points", sharp)))));
}

TEST(EglHybrid, AStopIsHeard) {
    EglDevice device;
    std::stop_source stop;
    stop.request_stop();
    const auto plan = makeFramePlan(sceneOf(layer("residual")), Quality::exact());
    EXPECT_FALSE(device.render(plan, PixelFormat::srgb8, stop.get_token()).has_value());
}

}  // namespace
}  // namespace mote::render
