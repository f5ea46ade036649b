// SPDX-License-Identifier: GPL-3.0-or-later
//
// The reference's layers that fade, against closed forms (docs/PICTURE.md, "Layers that fade").
#include <gtest/gtest.h>

#include <cmath>

#include "tests/reference/reference_renderer.h"
#include "tests/support/beams.h"
#include "tests/support/hybrid_scene.h"
#include "tests/support/memory_step.h"
#include "tests/support/view_text.h"

namespace mote::reference {
namespace {

using render::Scene;
using test::MemoryStep;
using test::WeightedPoint;

/// 20 x 20 pixels of a tenth, seen along -z.
View fadingView(const std::string& style) {
    return test::viewOf(
        "{'width': 20, 'height': 20, 'background': [0, 0, 1],"
        "'camera': {'eye': [0, 0, 4], 'target': [0, 0, 0], 'orthographicHeight': 2}, 'layers': [" +
        style + "]}");
}

std::string particles(const std::string& points, double opacity) {
    return "{'particles': {'volume': {'curve': [{'density': 0, 'opacity': " + std::to_string(opacity) +
           "}]}, 'points': {'linked': false, 'curve': [{'density': 0, 'fraction': 1}], " + points + "}}}";
}

/// The layer once, of w and of the rest of it.
Scene dissolved(const Scene& scene, double w) {
    Scene two = scene;
    two.view.layers.push_back(two.view.layers[0]);
    two.layers.push_back(two.layers[0]);
    two.view.layers[0].opacity *= w;
    two.view.layers[1].opacity *= 1.0 - w;
    return two;
}

double greatestDifference(const Picture& one, const Picture& other) {
    double most = 0.0;
    for (std::size_t i = 0; i < one.linear.size(); ++i) {
        for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(one.linear[i][c] - other.linear[i][c]));
    }
    return most;
}

TEST(ReferenceFading, AVolumeIsThinned) {
    const auto step = MemoryStep::make(
        {},
        {.volumeLevel = 2, .logDensity = LogDensity{1.0, 100.0}, .volume = std::vector<float>(64, 100.0F)});
    auto view = fadingView(particles("'opacity': 0", 0.02));
    for (const double w : {1.0, 0.7, 0.25, 1e-3}) {
        view.layers[0].opacity = w;
        // Through two units, each 32 times the length of the curve's opacity.
        const double left = std::pow(0.98, 64.0 * w), blue = ColorMap::standard()(1.0).z;
        EXPECT_NEAR(render({view, {{.step = step}}}).at(10, 10).z, left + (1.0 - left) * blue, 1e-6);
    }
}

TEST(ReferenceFading, APointHidesInProportionInEachPixel) {
    const auto step = MemoryStep::make({{{0.525, 0.525, 0.5}}}, {.volumeLevel = 0, .volume = {0.0F}});
    auto view = fadingView(particles("'opacity': 0.8, 'sizePixels': 4, 'color': [1, 0, 0]", 0.0));
    const auto whole = render({view, {{.step = step}}});
    for (const double w : {0.9, 0.5, 0.01}) {
        view.layers[0].opacity = w;
        const auto some = render({view, {{.step = step}}});
        for (std::size_t i = 0; i < some.linear.size(); ++i)
            EXPECT_NEAR(some.linear[i].z, std::pow(whole.linear[i].z, w), 1e-12) << w;
    }
    const double edge = whole.at(12, 9).z;
    EXPECT_TRUE(edge > 0.21 && edge < 1.0) << "a pixel that the point covers in part";
}

TEST(ReferenceFading, TwoThatShareAPlotAreThePlot) {
    const auto step = MemoryStep::make(test::beam({.core = 500, .halo = 300, .filaments = 100}));
    for (const char* const points : {"'opacity': 0.9, 'sizePixels': 0.5", "'opacity': 1, 'sizePixels': 3"}) {
        const Scene scene{fadingView(particles(points, 0.1)), {{.step = step}}};
        const auto whole = render(scene);
        for (const double w : {0.0, 0.3, 0.999, 1.0})
            EXPECT_LT(greatestDifference(render(dissolved(scene, w)), whole), 1e-9) << points << ' ' << w;
    }
}

TEST(ReferenceFading, TwoThatShareAVolumeAreTheVolume) {
    using enum HybridRepresentation;
    for (const auto parts : {residual, points}) {
        const auto hybrid = test::hybridOf({.threshold = 0.1, .parts = parts}, test::machineParts);
        Scene scene{fadingView("{'hybrid': {}}"), {{.hybrid = hybrid}}};
        scene.view.camera = fitCamera(hybrid->bounds(), 1.0);
        const auto whole = render(scene);
        for (const double w : {0.0, 0.4, 1.0})
            EXPECT_LT(greatestDifference(render(dissolved(scene, w)), whole), 1e-9) << w;
    }
}

TEST(ReferenceFading, OfNothingThereAreNoData) {
    Scene scene{fadingView("{'particles': {}}, {'hybrid': {}}, {'mesh': {}}, {'ink': {}}"), {}};
    for (auto& layer : scene.view.layers) layer.opacity = 0.0;
    scene.layers.resize(4);
    for (const auto& color : render(scene).linear) EXPECT_EQ(color, glm::dvec3(0.0, 0.0, 1.0));
}

TEST(ReferenceFading, SheetsOfAMeshGrowPaleOneByOne) {
    storage::SurfaceMesh mesh;
    for (const float z : {0.0F, 0.5F}) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (const glm::vec2 at : {glm::vec2(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
            mesh.positions.emplace_back(at, z);
            mesh.normals.emplace_back(0.0F, 0.0F, 1.0F);
        }
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.triangles.push_back({first, first + 2, first + 3});
    }
    const auto surface = std::make_shared<const render::MeshSurface>(
        std::move(mesh), Bounds{{-1.0, -1.0, 0.0}, {1.0, 1.0, 0.5}});
    const Scene scene{fadingView("{'opacity': 0.5, 'mesh': {'opacity': 0.6, 'color': [0, 0, 0]}}"),
                      {{.mesh = surface}}};
    EXPECT_NEAR(render(scene).at(10, 5).z, 0.7 * 0.7, 1e-12);
}

TEST(ReferenceFading, StrokesGrowPaleTogether) {
    render::Strokes strokes;
    strokes.points = {{-9.0F, 10.0F, 6.0F, 4.0},
                      {60.0F, 10.0F, 6.0F, 4.0},
                      {10.0F, -9.0F, 6.0F, 3.0},
                      {10.0F, 60.0F, 6.0F, 3.0}};
    strokes.lines = {{0, 2}, {2, 4}};
    strokes.opacity = 0.25F;
    const Scene scene{fadingView(""), {}};
    const auto picture = render(scene, {.strokes = {std::make_shared<const render::Strokes>(strokes)}});
    EXPECT_NEAR(picture.at(2, 10).z, 0.75, 1e-12);
    EXPECT_NEAR(picture.at(10, 10).z, 0.75, 1e-12);
    EXPECT_EQ(picture.at(2, 2).z, 1.0);
}

}  // namespace
}  // namespace mote::reference
