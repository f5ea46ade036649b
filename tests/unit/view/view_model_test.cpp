// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/view_model.h"

#include <gtest/gtest.h>

#include "client/view/layers/hybrid_editor.h"
#include "client/view/layers/particles_editor.h"
#include "client/view/layers/stipple_editor.h"
#include "client/view/slider_values.h"
#include "protocol/scene/json.h"
#include "protocol/scene/particles_style.h"
#include "protocol/scene/plot_density.h"
#include "protocol/scene/view.h"

namespace mote::client {
namespace {

/// The controls of the edited layer, which is of this kind.
template <class Editor>
auto& controls(ViewModel& model) {
    return dynamic_cast<Editor&>(model.editor()).controls;
}

template <class Editor>
bool edits(ViewModel& model) {
    return dynamic_cast<Editor*>(&model.editor()) != nullptr;
}

proto::View savedView() {
    proto::View view;
    const auto status = parseJson(R"({"width": 640, "height": 480, "background": [0.1, 0.2, 0.3],
        "camera": {"eye": [1, 2, 3], "target": [0, 0, 0], "up": [0, 1, 0], "fovYDegrees": 50},
        "layers": [{"dataset": "data/beam", "step": 2, "particles": {
            "volume": {"curve": [{"density": 0.5, "opacity": 0}, {"density": 0.8, "opacity": 0.2}],
                       "colorMap": "viridis"},
            "points": {"linked": false, "curve": [{"density": 0, "fraction": 1}], "opacity": 0.25,
                       "sizePixels": 2, "color": [1, 0.5, 0.25]}}},
          {"dataset": "data/other", "particles": {}}]})",
                                  view, "test");
    EXPECT_TRUE(status.ok()) << status.error().toString();
    return view;
}

proto::Manifest plotOf(int steps) {
    proto::Manifest manifest;
    manifest.set_kind("particles");
    for (int i = 0; i < steps; ++i) manifest.mutable_particles()->add_steps();
    return manifest;
}

/// A stippled surface in a box of 20 x 10 x 10.
proto::Manifest surface() {
    proto::Manifest manifest;
    manifest.set_kind("stipple");
    manifest.mutable_stipple()->set_domain(proto::StippleManifest::SURFACE);
    for (const double low : {0.0, 0.0, -10.0}) manifest.mutable_mesh()->add_bounds_min(low);
    for (const double high : {20.0, 10.0, 0.0}) manifest.mutable_mesh()->add_bounds_max(high);
    return manifest;
}

TEST(ViewModel, ALoadedViewIsTheViewThatIsShown) {
    ViewModel model;
    ASSERT_TRUE(model.load(savedView()).ok());
    const auto shown = parseView(model.view(640, 480)).value();
    const auto saved = parseView(savedView()).value();
    EXPECT_EQ(shown.layers.size(), 2U);
    EXPECT_EQ(shown.camera, saved.camera);
    EXPECT_EQ(shown.layers[0].particles()->volumeOpacity, saved.layers[0].particles()->volumeOpacity);
    EXPECT_EQ(shown.layers[0].particles()->pointFraction, saved.layers[0].particles()->pointFraction);
    EXPECT_EQ(shown.layers[0].particles()->colorMap, saved.layers[0].particles()->colorMap);
    // Colours pass through floats.
    EXPECT_NEAR(shown.layers[0].particles()->pointColor.y, saved.layers[0].particles()->pointColor.y, 1e-6);
    EXPECT_NEAR(shown.background.z, saved.background.z, 1e-6);
    EXPECT_EQ(shown.layers[1], saved.layers[1]);
}

TEST(ViewModel, ANewModelShowsAValidView) {
    ViewModel model;
    model.setDataset("data/beam", plotOf(3));
    const auto view = parseView(model.view(800, 600));
    ASSERT_TRUE(view.ok()) << view.error().toString();
    EXPECT_EQ(view->layers[0].dataset, "data/beam");
}

TEST(ViewModel, ABadViewIsRefusedAndNothingChanges) {
    ViewModel model;
    ASSERT_TRUE(model.load(savedView()).ok());
    auto bad = savedView();
    bad.mutable_layers(0)->mutable_particles()->mutable_points()->set_opacity(7.0);
    const auto status = model.load(bad);
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().where, "layers[0].particles.points.opacity");
    EXPECT_EQ(model.dataset(), "data/beam");
}

TEST(ViewModel, AnotherDatasetKeepsTheLookAndAStepThatExists) {
    ViewModel model;
    ASSERT_TRUE(model.load(savedView()).ok());
    model.setDataset("data/short", plotOf(2));
    EXPECT_EQ(model.step(), 1U);
    EXPECT_EQ(controls<ParticlesEditor>(model).colorMap, "viridis");
}

/// A plot so dense that it is drawn as a volume, too.
proto::Manifest largePlot() {
    auto manifest = plotOf(2);
    auto& plot = *manifest.mutable_particles();
    plot.set_density_min(1e2);
    plot.set_density_max(1e12);
    plot.mutable_steps(1)->set_particles(100'000'000);
    plot.mutable_steps(1)->set_total_weight(1e8);
    return manifest;
}

/// What the model says of how points look, and of the curves.
proto::ParticlesStyle written(ViewModel& model) {
    proto::ParticlesStyle style;
    controls<ParticlesEditor>(model).write(style);
    return style;
}

TEST(ViewModel, WhatThePlotSaysIsLeftOutUntilItIsChosen) {
    ViewModel model;
    model.setDataset("data/beam", plotOf(1));
    EXPECT_FALSE(written(model).points().has_opacity());
    EXPECT_FALSE(written(model).points().has_size_pixels());
    EXPECT_TRUE(written(model).volume().curve().empty());
    controls<ParticlesEditor>(model).pointOpacity = 0.1F;
    controls<ParticlesEditor>(model).pointSize = 2.0F;
    model.setDataset("data/large", largePlot());
    EXPECT_FLOAT_EQ(static_cast<float>(written(model).points().opacity()), 0.1F);
    EXPECT_FLOAT_EQ(static_cast<float>(written(model).points().size_pixels()), 2.0F);
    auto saved = savedView();
    saved.mutable_layers(0)->mutable_particles()->mutable_points()->set_opacity(0.25);
    ASSERT_TRUE(model.load(saved).ok());
    model.setDataset("data/large", largePlot());
    EXPECT_EQ(written(model).points().opacity(), 0.25);
}

TEST(ViewModel, CurvesAreThoseOfThePlotUntilTheyAreEdited) {
    ViewModel model;
    model.setDataset("data/large", largePlot());
    auto& functions = controls<ParticlesEditor>(model).functions;
    auto style = parseParticlesStyle({}).value();
    resolveByPlot(style, PlotDensity::of(largePlot().particles()));
    EXPECT_EQ(functions.knots(TransferFunctions::Which::volume), style.volumeOpacity.knots());
    EXPECT_GT(style.volumeOpacity.maximum(), 0.0);
    // The strip below the curve shows the colours that are drawn.
    for (const double t : {0.2, 0.6, 1.0})
        EXPECT_EQ(controls<ParticlesEditor>(model).drawn().color(t), style.transfer().color(t)) << t;
    functions.move(TransferFunctions::Which::volume, 0, {0.1, 0.05});
    model.setDataset("data/beam", plotOf(1));
    EXPECT_EQ(controls<ParticlesEditor>(model).functions.knots(TransferFunctions::Which::volume)[0],
              (Curve::Knot{0.1, 0.05}));
    EXPECT_FALSE(written(model).volume().curve().empty());
}

TEST(ViewModel, ASurfaceIsStippledAndFramed) {
    ViewModel model;
    ASSERT_TRUE(model.load(savedView()).ok());
    model.setDataset("data/teapot", surface());
    EXPECT_TRUE(edits<StippleEditor>(model));
    auto& style = dynamic_cast<StippleEditor&>(model.editor()).style;
    style.set_spacing_pixels(7.0);
    assign(style.mutable_light()->mutable_direction(), glm::dvec3(2.0, 0.0, 0.0));
    const auto view = parseView(model.view(640, 480));
    ASSERT_TRUE(view.ok()) << view.error().toString();
    ASSERT_NE(view->layers[0].stipple(), nullptr);
    EXPECT_EQ(view->layers[0].stipple()->spacing_pixels(), 7.0);
    EXPECT_EQ(view->layers[0].stipple()->light().direction(0), 1.0);
    EXPECT_EQ(view->camera.target, glm::dvec3(10.0, 5.0, -5.0));
    model.setDataset("data/beam", plotOf(1));
    EXPECT_FALSE(edits<StippleEditor>(model));
    EXPECT_EQ(parseView(model.view(640, 480))->camera.target, glm::dvec3(0.0));
}

/// A hybrid volume of 10 x 10 x 10 units, its corner at `corner`, of two steps.
proto::Manifest volume(double corner) {
    proto::Manifest manifest;
    manifest.set_kind("hybrid");
    auto& hybrid = *manifest.mutable_hybrid();
    for (int i = 0; i < 3; ++i) hybrid.add_source_size(10);
    for (int i = 0; i < 16; ++i)
        hybrid.add_index_to_world(i % 5 == 0 ? 1.0 : i % 4 == 3 ? corner + 0.5 : 0.0);
    hybrid.set_value_max(1.0);
    for (int step = 0; step < 2; ++step) hybrid.add_steps()->add_histogram(1);
    return manifest;
}

TEST(ViewModel, AVolumeIsShownAndFramed) {
    ViewModel model;
    ASSERT_TRUE(model.load(savedView()).ok());
    model.setDataset("data/engine", volume(10.0));
    EXPECT_TRUE(edits<HybridEditor>(model));
    EXPECT_EQ(model.step(), 1U);
    controls<HybridEditor>(model).rest.set_representation("points");
    const auto view = parseView(model.view(640, 480));
    ASSERT_TRUE(view.ok()) << view.error().toString();
    ASSERT_NE(view->layers[0].hybrid(), nullptr);
    EXPECT_EQ(view->layers[0].hybrid()->representation, HybridRepresentation::points);
    EXPECT_TRUE(view->layers[0].hybrid()->opacity.has_value());
    EXPECT_EQ(view->camera.target, glm::dvec3(15.0));
    model.setDataset("data/frog", volume(-10.0));  // elsewhere
    EXPECT_EQ(parseView(model.view(640, 480))->camera.target, glm::dvec3(-5.0));
    EXPECT_EQ(controls<HybridEditor>(model).rest.representation(), "points");
    model.setDataset("data/beam", plotOf(1));
    EXPECT_FALSE(edits<HybridEditor>(model));
    model.setDataset("data/engine", volume(10.0));
    EXPECT_GT(parseView(model.view(640, 480))->layers[0].hybrid()->opacity->maximum(), 0.0);
}

TEST(ViewModel, AStippleStyleIsKept) {
    auto saved = savedView();
    auto& style = *saved.mutable_layers(0)->mutable_stipple();
    style.set_dot_pixels(3.5);
    style.set_value("depth");
    style.mutable_light()->add_direction(0.3);
    style.mutable_light()->add_direction(-0.2);
    style.mutable_light()->add_direction(-0.7);
    ViewModel model;
    ASSERT_TRUE(model.load(saved).ok());
    const auto shown = parseView(model.view(640, 480)).value(), wanted = parseView(saved).value();
    EXPECT_EQ(shown.layers[0].stipple()->value(), "depth");
    EXPECT_EQ(*shown.layers[0].stipple(), *wanted.layers[0].stipple());
}

TEST(ViewModel, CurvesAreThoseOfAPlotAlsoAfterAnotherKindOfLayer) {
    ViewModel model, direct;
    model.setDataset("data/teapot", surface());
    model.setDataset("data/large", largePlot());
    direct.setDataset("data/large", largePlot());
    EXPECT_EQ(controls<ParticlesEditor>(model).functions, controls<ParticlesEditor>(direct).functions);
}

TEST(ViewModel, StepsAreThoseOfTheDataset) {
    ViewModel model;
    EXPECT_EQ(model.steps(), 0);
    model.setDataset("data/beam", plotOf(3));
    EXPECT_EQ(model.steps(), 3);
    model.setDataset("data/engine", volume(10.0));
    EXPECT_EQ(model.steps(), 2);
    model.setDataset("data/teapot", surface());
    EXPECT_EQ(model.steps(), 0);
}

TEST(ViewModel, TheCameraFitsUntilItIsMoved) {
    ViewModel model;
    EXPECT_NE(model.camera(0.5), model.camera(2.0));
    model.setCamera(model.camera(2.0));
    EXPECT_EQ(model.camera(0.5), model.camera(2.0));
    model.fit();
    EXPECT_NE(model.camera(0.5), model.camera(2.0));
}

TEST(ViewModel, WhatNoLayerDrawsIsAskedForAsParticles) {
    proto::Manifest picture;
    picture.set_kind("image");
    ViewModel model;
    model.setDataset("data/picture", picture);
    EXPECT_TRUE(model.view(64, 64).layers(0).has_particles());
}

}  // namespace
}  // namespace mote::client
