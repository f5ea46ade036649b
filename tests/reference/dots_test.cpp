// SPDX-License-Identifier: GPL-3.0-or-later
//
// The reference's dots against closed forms: their ink, their place in depth.
#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "tests/reference/reference_renderer.h"
#include "tests/support/memory_step.h"
#include "tests/support/view_text.h"

namespace mote::reference {
namespace {

using render::Dot;
using render::Dots;

constexpr double infinite = std::numeric_limits<double>::infinity();

/// 40 x 40 pixels, the eye 4 away, nothing but dots.
render::Scene sceneOf(Dots dots) {
    return {test::viewOf("{'width': 40, 'height': 40, 'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0],"
                         "'orthographicHeight': 2}}"),
            {},
            std::make_shared<const Dots>(std::move(dots))};
}

double ink(const Picture& picture) {
    double sum = 0.0;
    for (const auto& color : picture.linear) sum += color.x;
    return sum;
}

TEST(ReferenceDots, TheInkOfADiscIsItsArea) {
    for (const float radius : {0.1F, 0.5F, 0.6F, 1.0F, 1.7F, 4.0F}) {
        double sum = 0.0;
        constexpr int places = 16;
        for (int i = 0; i < places * places; ++i) {
            Dot dot{.x = 20.0F, .y = 20.0F, .depth = 4.0, .radius = radius};
            dot.x += static_cast<float>(i % places) / places;
            dot.y += static_cast<float>(i / places) / places;
            sum += ink(render(sceneOf({dot})));
        }
        const double area = std::numbers::pi * radius * radius;
        // The mean over all places is the integral; 16 x 16 places are the midpoint rule for a footprint that
        // is linear but for two kinks.
        EXPECT_NEAR(sum / (places * places), area, 0.004 * area) << radius;
    }
}

TEST(ReferenceDots, TheNearerHidesTheFarther) {
    const Dot red{.x = 20.5F, .y = 20.5F, .depth = 3.0, .radius = 2.0F, .color = {1.0F, 0.0F, 0.0F}};
    Dot green = red;
    green.color = {0.0F, 1.0F, 0.0F};
    green.depth = 3.5;
    EXPECT_EQ(render(sceneOf({green, red})).at(20, 20), glm::dvec3(1.0, 0.0, 0.0));
    green.depth = 3.0;  // of equal depth, the earlier
    EXPECT_EQ(render(sceneOf({green, red})).at(20, 20), glm::dvec3(0.0, 1.0, 0.0));
    green.depth = -infinite;
    EXPECT_EQ(render(sceneOf({red, green})).at(20, 20), glm::dvec3(0.0, 1.0, 0.0));
    green.depth = infinite;
    EXPECT_EQ(render(sceneOf({green, red})).at(20, 20), glm::dvec3(1.0, 0.0, 0.0));
}

TEST(ReferenceDots, StandBetweenPoints) {
    auto scene = sceneOf({Dot{.x = 20.5F, .y = 20.5F, .depth = 4.0, .radius = 2.0F, .opacity = 0.5F}});
    const auto dots = scene.dots;
    scene = {
        test::viewOf("{'width': 40, 'height': 40, 'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0],"
                     "'orthographicHeight': 2}, 'layers': [{'particles': {'volume': {'curve':"
                     "[{'density': 0, 'opacity': 0}]}, 'points': {'opacity': 0.5, 'color': [1, 0, 0]}}}]}"),
        {{.step = test::MemoryStep::make({{{0.5125, 0.4875, 0.25}}, {{0.5125, 0.4875, 0.75}}},
                                         {.volumeLevel = 0, .volume = {0.0F}})}},
        dots};
    // A red point, half of what is left the white dot, and half of that red again.
    const auto color = render(scene).at(20, 20);
    EXPECT_NEAR(color.x, 0.5 + 0.25 + 0.125, 1e-12);
    EXPECT_NEAR(color.y, 0.25, 1e-12);
}

}  // namespace
}  // namespace mote::reference
