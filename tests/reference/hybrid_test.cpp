// SPDX-License-Identifier: GPL-3.0-or-later
//
// The reference's hybrid volumes against closed forms: field, extinction, light, what points do and what is
// cut away.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "storage/hybrid/normal_table.h"
#include "tests/reference/hybrid_field.h"
#include "tests/reference/reference_renderer.h"
#include "tests/support/hybrid_scene.h"
#include "tests/support/view_text.h"

namespace mote::reference {
namespace {

using test::hybridOf;
using test::HybridShape;

/// Twelve by ten by eight units, the middle at the origin.
glm::dmat4 plainBox() {
    return glm::scale(glm::translate(glm::dmat4(1.0), glm::dvec3(-6.0, -5.0, -4.0)),
                      glm::dvec3(12.0, 10.0, 8.0));
}

render::Scene sceneOf(std::shared_ptr<const render::GridField> step, const std::string& style,
                      const std::string& camera = "'orthographicHeight': 16") {
    return {test::viewOf("{'width': 32, 'height': 32, 'camera': {'eye': [0, 0, 40], 'target': [0, 0, 0], " +
                         camera + "}, 'layers': [{'hybrid': " + style + "}]}"),
            {{.hybrid = std::move(step)}}};
}

const std::string noLight = "'light': {'ambient': 1, 'diffuse': 0, 'specular': 0}";
const std::string haze =
    "{'representation': 'volume', 'curve': [{'value': 0, 'opacity': 0.01, 'color': [1, 1, 1]}], " + noLight;

double through(double length) {
    return 1.0 - std::pow(0.99, length / (12.0 / 256.0));
}

TEST(ReferenceHybrid, AnEvenVolumeAbsorbsByLength) {
    const auto step = hybridOf({.boxToLayer = plainBox()}, [](const auto&) { return 0.5; });
    const auto picture = render(sceneOf(step, haze + "}"));
    EXPECT_NEAR(picture.at(16, 16).x, through(8.0), 1e-6);
    EXPECT_EQ(picture.at(16, 2).x, 0.0);                    // y = 6.75, above the box
    EXPECT_NEAR(picture.at(27, 16).x, through(8.0), 1e-6);  // x = 5.75
    EXPECT_EQ(picture.at(28, 16).x, 0.0);
}

TEST(ReferenceHybrid, PlanesAndBoxCutIt) {
    const auto step = hybridOf({.boxToLayer = plainBox()}, [](const auto&) { return 0.5; });
    const auto half =
        render(sceneOf(step, haze + ", 'clipPlanes': [{'normal': [0, 0, -2], 'distance': -2}]}"));
    EXPECT_NEAR(half.at(16, 16).x, through(5.0), 1e-6);  // z from -4 to 1
    const auto box = render(sceneOf(step, haze + ", 'clipBox': {'min': [-1, -10, -3], 'max': [1, 10, -1]}}"));
    EXPECT_NEAR(box.at(16, 16).x, through(2.0), 1e-6);
    EXPECT_EQ(box.at(20, 16).x, 0.0);
}

TEST(ReferenceHybrid, WhatChangesLittleIsLetThrough) {
    // From 0 to 1 along x: a 64th of that within a 64th of the longest edge, which x is.
    const auto step = hybridOf({.source = {16, 16, 16}, .low = {16, 16, 16}, .boxToLayer = plainBox()},
                               [](const auto& at) { return at.x; });
    const double deviation = std::sqrt((16.0 * 16.0 - 1.0) / 12.0) / 16.0;
    const double slope = std::round(255.0 / 64.0 / deviation) / 255.0;
    for (const double gradient : {0.25, 1.0}) {
        const auto picture =
            render(sceneOf(step, haze + ", 'gradientOpacity': " + std::to_string(gradient) + "}"));
        EXPECT_NEAR(picture.at(16, 16).x, through(8.0 * (1.0 - gradient + gradient * slope)), 1e-5);
    }
    // Where all is alike, nothing changes.
    const auto even = hybridOf({.boxToLayer = plainBox()}, [](const auto&) { return 0.5; });
    EXPECT_EQ(render(sceneOf(even, haze + ", 'gradientOpacity': 1}")).at(16, 16).x, 0.0);
}

TEST(ReferenceHybrid, ACorrectedBrickIsTheSourceItself) {
    // A field that no grid of 4 holds, in a box of uneven edges.
    const auto field = [](const glm::dvec3& at) {
        return 0.5 + 0.4 * std::sin(9.0 * at.x) * std::cos(7.0 * at.y + at.z);
    };
    const HybridShape shape{.source = {20, 18, 13}, .low = {4, 4, 4}, .boxToLayer = plainBox()};
    const auto scene = sceneOf(hybridOf(shape, field), "{'representation': 'residual'}");
    const HybridField drawn(*scene.layers[0].hybrid, scene.view.layers[0], scene.view.camera);
    const auto at = [&](double x, double y, double z) {
        return (glm::dvec3(x, y, z) + 0.5) / glm::dvec3(shape.source);
    };
    const auto value = [&](const glm::dvec3& inBox) {
        return drawn.value(glm::dvec3(plainBox() * glm::dvec4(inBox, 1.0)));
    };
    // Half a step of 16 bits, and the float in which the residual was told.
    constexpr double quantisation = 0.5 / 65535.0 + 1e-6;
    for (unsigned z = 0; z < shape.source.z; ++z) {
        for (unsigned y = 0; y < shape.source.y; ++y) {
            for (unsigned x = 0; x < shape.source.x; ++x)
                ASSERT_NEAR(value(at(x, y, z)), field(at(x, y, z)), quantisation)
                    << x << ' ' << y << ' ' << z;
        }
    }
    // Between samples it is linear in the source's samples, also from one brick to the next (7 to 8).
    EXPECT_NEAR(value(at(7.25, 3, 3)), 0.75 * field(at(7, 3, 3)) + 0.25 * field(at(8, 3, 3)),
                2 * quantisation);
}

TEST(ReferenceHybrid, WithoutResidualsItIsTheLowVolume) {
    const auto flat =
        hybridOf({.source = {32, 32, 32}, .low = {8, 8, 8}, .threshold = 10.0}, test::machineParts);
    EXPECT_EQ(flat->bricks->corrected(), 0U);
    const auto scene = sceneOf(flat, "{'representation': 'residual'}");
    const auto low = sceneOf(flat, "{'representation': 'volume'}");
    const HybridField one(*flat, scene.view.layers[0], scene.view.camera);
    const HybridField other(*flat, low.view.layers[0], low.view.camera);
    for (const double x : {0.01, 0.3, 0.55, 0.99}) {
        const glm::dvec3 place(x, 0.4, 0.7 * x);
        EXPECT_EQ(one.value(place), other.value(place));
    }
}

TEST(ReferenceHybrid, BothSidesAreLit) {
    const Light light{.direction = {0.0, 0.0, 1.0}, .ambient = 0.2, .diffuse = 0.6, .specular = 0.5};
    const storage::NormalTable table;
    const auto camera =
        test::viewOf("{'width': 1, 'height': 1, 'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0]}}").camera;
    const auto shade = [&](const glm::vec3& normal) {
        return shadeOf(table.code(normal), light, glm::dmat4(1.0), camera);
    };
    // A direction of the table lies within 8 degrees of any: cos 8 = 0.990, its 32nd power 0.73.
    for (const float z : {1.0F, -1.0F}) {
        EXPECT_NEAR(shade({0.0F, 0.0F, z}).diffuse, 0.8, 0.6 * 0.01);
        EXPECT_GT(shade({0.0F, 0.0F, z}).specular, 0.5 * 0.73);
    }
    EXPECT_LT(shade({1.0F, 0.0F, 0.0F}).diffuse, 0.2 + 0.6 * std::sin(8.0 / 57.3));
    EXPECT_EQ(shadeOf(storage::NormalTable::none, light, glm::dmat4(1.0), camera).diffuse, 0.8);
}

/// Along x, from the middle of sample 3 to that of sample 4, in cells: the field where sample 4 alone is a
/// point.
class OnePoint : public testing::Test {
  protected:
    static double field(const glm::dvec3& at) { return std::abs(at.x - 4.5 / 8.0) < 0.01 ? 0.8 : 0.2; }
    double at(const std::string& style, double share) const {
        const auto step =
            hybridOf({.source = {8, 1, 1}, .low = {2, 1, 1}, .parts = HybridRepresentation::points}, field);
        const auto scene = sceneOf(step, "{'representation': 'points'" + style + "}");
        const HybridField drawn(*step, scene.view.layers[0], scene.view.camera);
        return drawn.value(glm::dvec3((3.5 + share) / 8.0, 0.5, 0.5));
    }
};

// A point's value has 8 bits, and 0.2 and 0.8 are codes of them; the coarse grid's has 16.
constexpr double halfCode = 0.5 / 65535.0;

TEST_F(OnePoint, FillsItsCellByItsShape) {
    const auto value = [](double weight) { return 0.2 + 0.6 * weight; };
    for (const double share : {0.0, 0.2, 0.25, 0.4375, 0.5, 0.55, 0.6, 0.8, 1.0}) {
        EXPECT_NEAR(at("", share), value(share), halfCode);
        EXPECT_NEAR(at(", 'pointShape': 'gaussian'", share), value(share), halfCode);
        const double disc = std::clamp(2.0 * share - 0.5, 0.0, 1.0);
        EXPECT_NEAR(at(", 'pointShape': 'disc'", share), value(disc), halfCode);
        // A face is an eighth of a cell thick.
        const double square = std::clamp(8.0 * share - 3.5, 0.0, 1.0);
        EXPECT_NEAR(at(", 'pointShape': 'square'", share), value(square), halfCode);
    }
}

TEST_F(OnePoint, CorrectsAsMuchAsItsOpacitySays) {
    for (const double opacity : {0.0, 0.25, 1.0}) {
        const std::string style = ", 'pointOpacity': " + std::to_string(opacity);
        for (const double share : {0.0, 0.3, 1.0})
            EXPECT_NEAR(at(style, share), 0.2 + 0.6 * opacity * share, halfCode);
    }
}

TEST(ReferenceHybrid, PointsOfAllErrorsAreTheSourceToEightBits) {
    const HybridShape shape{.source = {20, 18, 13}, .low = {5, 5, 4}, .parts = HybridRepresentation::points};
    const auto step = hybridOf(shape, test::machineParts);
    const auto scene = sceneOf(step, "{'representation': 'points'}");
    const HybridField drawn(*step, scene.view.layers[0], scene.view.camera);
    for (unsigned i = 0; i < 20 * 18 * 13; ++i) {
        const glm::uvec3 sample(i % 20, i / 20 % 18, i / 20 / 18);
        const glm::dvec3 place = (glm::dvec3(sample) + 0.5) / glm::dvec3(shape.source);
        ASSERT_NEAR(drawn.value(place), test::machineParts(place), 0.5 / 255.0 + halfCode) << i;
    }
}

}  // namespace
}  // namespace mote::reference
