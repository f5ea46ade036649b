// SPDX-License-Identifier: GPL-3.0-or-later
//
// The reference's hybrid volumes against closed forms: field, extinction, light, points and what is cut away.
#include <gtest/gtest.h>

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

render::Scene sceneOf(std::shared_ptr<const render::HybridStep> step, const std::string& style,
                      const std::string& camera = "'orthographicHeight': 16") {
    return {test::viewOf("{'width': 32, 'height': 32, 'camera': {'eye': [0, 0, 40], 'target': [0, 0, 0], " +
                         camera + "}, 'layers': [{'hybrid': " + style + "}]}"),
            {nullptr},
            {},
            {std::move(step)}};
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

TEST(ReferenceHybrid, ACorrectedBrickIsTheSourceItself) {
    // A field that no grid of 4 holds, in a box of uneven edges.
    const auto field = [](const glm::dvec3& at) {
        return 0.5 + 0.4 * std::sin(9.0 * at.x) * std::cos(7.0 * at.y + at.z);
    };
    const HybridShape shape{.source = {20, 18, 13}, .low = {4, 4, 4}, .boxToLayer = plainBox()};
    const auto scene = sceneOf(hybridOf(shape, field), "{'representation': 'residual'}");
    const HybridField drawn(*scene.hybrids[0], scene.view.layers[0], scene.view.camera);
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

/// What one point puts on the screen, over its own opacity: pixels.
double inkOf(const std::string& shape, double size, const glm::dvec3& place) {
    auto step = std::make_shared<render::HybridStep>(*hybridOf(
        {.source = {8, 8, 8}, .low = {2, 2, 2}, .boxToLayer = glm::scale(glm::dmat4(1.0), glm::dvec3(8.0))},
        [](const auto&) { return 0.0; }));
    step->points = std::make_shared<const render::HybridPoints>(render::HybridPoints{
        .size = {8, 8, 8}, .errorStep = 1.0 / 127.0, .points = {{4, 4, 4, 255, 255, 0}}});
    auto scene = sceneOf(
        step,
        "{'representation': 'points', 'pointShape': '" + shape + "', 'pointSize': " + std::to_string(size) +
            ", 'pointOpacity': 0.001, " + noLight +
            ", 'curve': [{'value': 0, 'opacity': 0, 'color': [1, 1, 1]}, {'value': 1, 'opacity': 0.9999, "
            "'color': [1, 1, 1]}]}");
    scene.view.layers[0].transform = glm::translate(glm::dmat4(1.0), place - 4.5);
    double sum = 0.0;
    for (const auto& color : render(scene, {1.0}).linear) sum += color.x;
    return sum / 0.001;
}

TEST(ReferenceHybrid, PointsOfAnySizeCoverTheirCell) {
    // 2 pixels a unit, a unit a cell: 4 pixels. Their opacity is 1 within 1e-4: the limit of opacity over a
    // 32nd of the cell, and a surface of no depth.
    for (const char* const shape : {"square", "disc", "gaussian"}) {
        const bool soft = std::string(shape) == "gaussian";
        for (const double size : {0.3, 0.5, 0.8, 1.0, 1.7}) {
            if (soft && size < 1.0) continue;  // would be more than opaque in its middle
            double sum = 0.0;
            constexpr int places = 4;
            for (int i = 0; i < places * places; ++i) {
                // Pixels are half a unit: all places within one.
                const glm::dvec3 place(0.5 * (i % places + 0.5) / places, 0.5 * (i / places + 0.5) / places,
                                       0.0);
                sum += inkOf(shape, size, place) / (places * places);
            }
            // A square or a disc smaller than its cell covers less of it. A gaussian is cut at three
            // deviations, which leaves out 1.1%.
            const bool small = size < 1.0;
            const double edge = std::string(shape) == "square" ? std::ceil(2.0 * size - 1e-9) : 2.0 * size;
            const double expected = small ? std::min(4.0, edge * edge) : 4.0;
            EXPECT_NEAR(sum, expected, 0.02 * expected) << shape << ' ' << size;
        }
    }
}

}  // namespace
}  // namespace mote::reference
