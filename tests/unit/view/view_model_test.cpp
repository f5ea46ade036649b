// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <cstdio>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

#include "client/shared/jobs.h"
#include "client/view/camera_control.h"
#include "client/view/files/view_files.h"
#include "client/view/layers/hybrid_editor.h"
#include "client/view/layers/image_editor.h"
#include "client/view/layers/particles_editor.h"
#include "client/view/layers/stipple_editor.h"
#include "client/view/panel.h"
#include "client/view/panel_widgets.h"
#include "client/view/replot.h"
#include "client/view/slider_values.h"
#include "client/view/time_bar.h"
#include "client/view/view_model.h"
#include "protocol/base/json.h"
#include "protocol/scene/particles_style.h"
#include "protocol/scene/plot_density.h"
#include "protocol/scene/view.h"
#include "tests/support/temp_dir.h"

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
    const auto drawn = particlesStyleOf(*shown.layers[0].particles());
    const auto wanted = particlesStyleOf(*saved.layers[0].particles());
    EXPECT_EQ(drawn.volumeOpacity, wanted.volumeOpacity);
    EXPECT_EQ(drawn.pointFraction, wanted.pointFraction);
    EXPECT_EQ(drawn.colorMap, wanted.colorMap);
    // Colours pass through floats.
    EXPECT_NEAR(drawn.pointColor.y, wanted.pointColor.y, 1e-6);
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
    auto style = particlesStyleOf(parseParticlesStyle({}).value());
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
    EXPECT_EQ(view->layers[0].hybrid()->representation(), "points");
    EXPECT_FALSE(view->layers[0].hybrid()->curve().empty());
    EXPECT_EQ(view->camera.target, glm::dvec3(15.0));
    model.setDataset("data/frog", volume(-10.0));  // elsewhere
    EXPECT_EQ(parseView(model.view(640, 480))->camera.target, glm::dvec3(-5.0));
    EXPECT_EQ(controls<HybridEditor>(model).rest.representation(), "points");
    model.setDataset("data/beam", plotOf(1));
    EXPECT_FALSE(edits<HybridEditor>(model));
    model.setDataset("data/engine", volume(10.0));
    EXPECT_GT(hybridStyleOf(*parseView(model.view(640, 480))->layers[0].hybrid()).opacity->maximum(), 0.0);
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
    proto::Manifest later;
    later.set_kind("of a later version");
    ViewModel model;
    model.setDataset("data/later", later);
    EXPECT_TRUE(model.view(64, 64).layers(0).has_particles());
}

TEST(ViewModel, AnImageIsALayerWithoutAPlace) {
    proto::Manifest picture;
    picture.set_kind("image");
    ViewModel model;
    model.setDataset("data/picture", picture);
    EXPECT_TRUE(model.view(64, 64).layers(0).has_image());
    EXPECT_NE(dynamic_cast<const ImageEditor*>(&model.editor()), nullptr);
    EXPECT_FALSE(model.layerBounds());
    EXPECT_TRUE(parseView(model.view(64, 64)).ok());
    const proto::Manifest mesh = [] {
        proto::Manifest made;
        made.set_kind("mesh");
        return made;
    }();
    model.addLayer("data/mesh", mesh);
    EXPECT_TRUE(model.view(64, 64).layers(1).has_mesh());
    EXPECT_TRUE(model.layerBounds());
}

constexpr double tolerance = 1e-9;  // double rounding of a few rotations, with room

/// Where a world point appears, in heights of the picture from its middle, y down as the mouse.
glm::dvec2 onScreen(const Camera& camera, const glm::dvec3& point) {
    const glm::dvec4 eye = camera.worldToEye() * glm::dvec4(point, 1.0);
    const double depth = camera.perspective() ? -eye.z : 1.0;
    return glm::dvec2(eye.x, -eye.y) / (2.0 * camera.halfHeight() * depth);
}

TEST(CameraControl, OrbitKeepsDistanceAndTarget) {
    const Camera before;
    const Camera after = orbit(before, {0.3, -0.2}, before.target);
    EXPECT_NEAR(glm::distance(after.eye, after.target), glm::distance(before.eye, before.target), tolerance);
    EXPECT_EQ(after.target, before.target);
    EXPECT_GT(glm::distance(after.eye, before.eye), 0.5);
}

TEST(CameraControl, OrbitFollowsTheMouse) {
    // A point in front of the target moves the way the mouse does.
    const Camera before;
    const glm::dvec3 front(0.0, 0.0, 0.5);
    EXPECT_GT(onScreen(orbit(before, {0.1, 0.0}, before.target), front).x, onScreen(before, front).x);
    EXPECT_GT(onScreen(orbit(before, {0.0, 0.1}, before.target), front).y, onScreen(before, front).y);
}

TEST(CameraControl, OrbitStopsAtThePoles) {
    Camera camera;
    for (int i = 0; i < 50; ++i) camera = orbit(camera, {0.0, 0.2}, camera.target);
    EXPECT_TRUE(parseCamera(toProto(camera)).ok());
    EXPECT_GT(camera.eye.y, 3.9);
}

TEST(CameraControl, PanKeepsTheTargetPlaneUnderTheMouse) {
    const glm::dvec2 drag(0.17, -0.08);
    for (const Camera& before : {Camera{}, toggleProjection(Camera{})}) {
        const glm::dvec2 moved = onScreen(pan(before, drag), before.target) - onScreen(before, before.target);
        EXPECT_NEAR(moved.x, drag.x, tolerance);
        EXPECT_NEAR(moved.y, drag.y, tolerance);
    }
}

TEST(CameraControl, DollyMovesTheEyeAndZoomDoesNot) {
    const Camera before;
    EXPECT_LT(glm::distance(dolly(before, 1.0, before.target).eye, before.target),
              glm::distance(before.eye, before.target));
    EXPECT_EQ(zoom(before, 1.0).eye, before.eye);
    EXPECT_LT(zoom(before, 1.0).fovYDegrees, before.fovYDegrees);
}

TEST(CameraControl, TheEyeGoesToAnySideOfTheTarget) {
    const Camera before = pan(orbit(Camera{}, {0.3, 0.1}, {}), {0.1, 0.2});
    const auto front = lookFrom(before, 1, false);
    EXPECT_NEAR(glm::distance(front.eye, before.target), glm::distance(before.eye, before.target), tolerance);
    EXPECT_LT(front.eye.y, before.target.y);
    EXPECT_EQ(front.up, glm::dvec3(0.0, 0.0, 1.0));
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_TRUE(parseCamera(toProto(lookFrom(before, axis, true))).ok());
        EXPECT_TRUE(parseCamera(toProto(lookFrom(before, axis, false))).ok());
    }
}

TEST(CameraControl, WhatIsUnderThePointerStaysThere) {
    const double aspect = 1.5;
    const glm::dvec2 at(0.8, 0.3);
    const Bounds box{glm::dvec3(-3.0, -1.0, -1.0), glm::dvec3(3.0, 1.0, 1.0)};
    const Camera tilted = roll(orbit(Camera{}, {0.1, 0.1}, {}), 0.4);
    for (const Camera& before : {tilted, toggleProjection(tilted)}) {
        const glm::dvec2 place((at.x - 0.5) * aspect, at.y - 0.5);  // heights from the middle
        const auto beside = placeAt(before, aspect, at);
        EXPECT_NEAR(glm::distance(onScreen(before, beside), place), 0.0, tolerance);
        EXPECT_NEAR(glm::dot(beside - before.target, before.eye - before.target), 0.0, tolerance);
        const auto within = placeWithin(before, aspect, at, box);
        ASSERT_TRUE(within);
        EXPECT_NEAR(glm::distance(onScreen(before, *within), place), 0.0, tolerance);
        for (int i = 0; i < 3; ++i) EXPECT_TRUE((*within)[i] > box.min[i] && (*within)[i] < box.max[i]);
        EXPECT_FALSE(placeWithin(before, aspect, {0.02, 0.02}, {glm::dvec3(-0.1), glm::dvec3(0.1)}));
        for (const Camera& after : {orbit(before, {0.2, 0.05}, *within), dolly(before, 3.0, *within)}) {
            EXPECT_TRUE(parseCamera(toProto(after)).ok());
            EXPECT_NE(after, before);
        }
        const auto nearer = dolly(before, 3.0, *within);
        EXPECT_NEAR(glm::distance(onScreen(nearer, *within), place), 0.0, tolerance);
    }
}

TEST(CameraControl, RollingAFullTurnIsNothing) {
    Camera camera = orbit(Camera{}, {0.3, 0.1}, {});
    const glm::dvec2 before = onScreen(camera, {0.5, 0.2, 0.1});
    for (int i = 0; i < 4; ++i) {
        camera = roll(camera, glm::half_pi<double>());
        if (i > 0) continue;
        // Counterclockwise; y is down.
        EXPECT_NEAR(glm::distance(onScreen(camera, {0.5, 0.2, 0.1}), {before.y, -before.x}), 0.0, tolerance);
    }
    EXPECT_NEAR(glm::distance(onScreen(camera, {0.5, 0.2, 0.1}), before), 0.0, tolerance);
}

TEST(CameraControl, FittingAlongADirectionKeepsIt) {
    Camera fitted;
    fitted.eye = {1.0, 2.0, 9.0};
    fitted.target = {1.0, 2.0, 3.0};
    const auto camera = lookFrom(Camera{}, 0, true);
    const auto along = fitAlong(camera, fitted);
    EXPECT_EQ(along.target, fitted.target);
    EXPECT_NEAR(glm::distance(along.eye, glm::dvec3(7.0, 2.0, 3.0)), 0.0, tolerance);
}

TEST(ViewModel, LayersHaveNamesAndAreHidden) {
    ViewModel model;
    model.setDataset("data/beam", plotOf(3));
    model.addLayer("data/teapot", surface());
    ASSERT_TRUE(model.setName(0, "the core").ok());
    EXPECT_EQ(model.setName(0, std::string(201, 'a')).error().where, "layers[0].name");
    model.setShown(0, false);
    // A file keeps both, wherever the layer goes; another view of it draws it as before.
    model.moveLayer(0, 1);
    ViewModel other;
    ASSERT_TRUE(other.load(model.view(64, 64)).ok());
    EXPECT_EQ(other.edited().layers(1).name(), "the core");
    EXPECT_TRUE(other.isShown(0));
    EXPECT_FALSE(other.isShown(1));
    other.setShown(1, true);
    EXPECT_FALSE(other.edited().layers(1).hidden());
    EXPECT_FALSE(other.edited().layers(1).has_opacity());
}

TEST(ViewModel, ALayerThatWasHiddenByItsOpacityIsShownAgain) {
    ViewModel model;
    model.setDataset("data/beam", plotOf(3));
    auto before = model.view(64, 64);
    before.mutable_layers(0)->set_opacity(0.0);  // as sessions of older viewers say it
    ASSERT_TRUE(model.load(before).ok());
    EXPECT_FALSE(model.isShown(0));
    model.setShown(0, true);
    EXPECT_TRUE(model.isShown(0));
    EXPECT_FALSE(model.edited().layers(0).has_opacity());
}

TEST(ViewModel, LayersComeGoAndChangePlaces) {
    ViewModel model;
    model.setDataset("data/beam", plotOf(3));
    model.addLayer("data/teapot", surface());
    ASSERT_EQ(model.layers().size(), 2);
    EXPECT_EQ(model.chosen(), 1);
    EXPECT_TRUE(edits<StippleEditor>(model));
    model.choose(0);
    EXPECT_TRUE(edits<ParticlesEditor>(model));
    controls<ParticlesEditor>(model).colorMap = "viridis";
    model.duplicateLayer(0);
    ASSERT_EQ(model.layers().size(), 3);
    EXPECT_EQ(controls<ParticlesEditor>(model).colorMap, "viridis");
    model.moveLayer(2, 0);
    EXPECT_EQ(model.layers()[0].dataset(), "data/teapot");
    model.setOpacity(0, 0.5);
    model.setShown(0, false);
    EXPECT_FALSE(model.isShown(0));
    EXPECT_TRUE(model.edited().layers(0).hidden());
    model.setShown(0, true);
    EXPECT_FALSE(model.edited().layers(0).hidden());
    EXPECT_EQ(model.edited().layers(0).opacity(), 0.5);
    model.removeLayer(0);
    EXPECT_EQ(model.chosen(), 0);
    EXPECT_EQ(model.edited().layers(1).particles().volume().color_map(), "viridis");
    EXPECT_TRUE(parseView(model.view(64, 64)).ok());
    model.keepOnlyChosen();
    EXPECT_EQ(model.layers().size(), 1);
    model.removeLayer(0);
    EXPECT_TRUE(model.layers().empty());
    model.addLayer("data/teapot", surface());
    EXPECT_TRUE(edits<StippleEditor>(model));
}

TEST(ViewModel, LayersAtOneStepGoOnTogether) {
    ViewModel model;
    model.setDataset("data/beam", plotOf(3));
    model.addLayer("data/engine", volume(10.0));  // two steps
    model.addLayer("data/long", plotOf(9));
    model.setStep(1);
    for (const auto& layer : model.layers()) EXPECT_EQ(layer.step(), 1U);
    model.setStep(2);
    EXPECT_EQ(model.layers()[1].step(), 1U);
    EXPECT_EQ(model.layers()[0].step(), 2U);
}

TEST(ViewModel, StepsArePlayedOfALayerThatHasThem) {
    ViewModel model;
    model.setDataset("data/beam", plotOf(3));
    model.addLayer("data/teapot", surface());
    EXPECT_EQ(model.steps(), 0);
    EXPECT_EQ(model.timedSteps(), 3);
    model.setTimedStep(2);
    EXPECT_EQ(model.layers()[0].step(), 2U);
    EXPECT_EQ(model.layers()[1].step(), 0U);
}

TEST(ViewModel, TheCameraIsTheServersUntilItIsMoved) {
    ViewModel model;
    model.setDataset("data/beam", plotOf(1));
    Camera served;
    served.eye = {1.0, 2.0, 3.0};
    served.target = {0.5, 0.0, 0.0};
    model.setServed(served);
    EXPECT_EQ(model.camera(0.5), served);
    EXPECT_FALSE(model.asked(64, 64).has_camera());
    EXPECT_EQ(model.view(64, 64).camera().eye(2), 3.0);
    model.setCamera(pan(served, {0.1, 0.0}));
    EXPECT_NE(model.camera(0.5), served);
    model.setDataset("data/teapot", surface());
    EXPECT_NE(model.camera(0.5), served);
}

TEST(CameraControl, NoGestureLeavesTheValidCameras) {
    for (Camera camera : {Camera{}, toggleProjection(Camera{})}) {
        for (const double steps : {1e6, -1e6, 1e6}) {
            camera = zoom(dolly(camera, steps, camera.target), steps);
            EXPECT_TRUE(parseCamera(toProto(camera)).ok()) << steps;
        }
    }
}

TEST(CameraControl, TogglingProjectionTwiceIsNothing) {
    const Camera before = orbit(Camera{}, {0.2, 0.1}, {});
    const Camera after = toggleProjection(toggleProjection(before));
    EXPECT_NEAR(glm::distance(after.eye, before.eye), 0.0, tolerance);
    EXPECT_TRUE(after.perspective());
}

/// Two steps a second, from second 10 on.
Playback playing() {
    Playback playback;
    playback.playing = true;
    playback.stepsPerSecond = 2.0F;
    EXPECT_EQ(playback.next(10.0, 0, 5, true), 1U);
    return playback;
}

TEST(Playback, KeepsToItsRate) {
    auto playback = playing();
    EXPECT_EQ(playback.next(10.25, 1, 5, true), std::nullopt);
    EXPECT_EQ(playback.next(10.5, 1, 5, true), 2U);
}

TEST(Playback, LeavesNoStepOutThatWasNotSeen) {
    auto playback = playing();
    EXPECT_EQ(playback.next(12.0, 1, 5, false), std::nullopt);
    EXPECT_EQ(playback.next(13.0, 1, 5, true), 2U);
    EXPECT_EQ(playback.next(13.25, 2, 5, true), std::nullopt) << "what is late is not made up for";
}

TEST(Playback, BeginsAnewAtTheEnd) {
    auto playback = playing();
    EXPECT_EQ(playback.next(11.0, 4, 5, true), 0U);
}

TEST(Playback, GoesBackAndInStridesAndMayEnd) {
    auto playback = playing();
    playback.stride = 3;
    EXPECT_EQ(playback.next(11.0, 1, 5, true), 4U);
    playback.backwards = true;
    EXPECT_EQ(playback.next(12.0, 4, 5, true), 1U);
    EXPECT_EQ(playback.next(13.0, 1, 5, true), 4U);
    playback.loop = false;
    EXPECT_EQ(playback.next(14.0, 1, 5, true), std::nullopt);
    EXPECT_FALSE(playback.playing);
}

TEST(TimeBar, ScalesAreThoseThatTellStepsApart) {
    auto manifest = plotOf(3);
    auto& plot = *manifest.mutable_particles();
    EXPECT_TRUE(timeScales(manifest).empty());
    for (int i = 0; i < 3; ++i) plot.mutable_steps(i)->set_time(2e-9 * i);
    ASSERT_EQ(timeScales(manifest).size(), 1U);
    EXPECT_EQ(timeScales(manifest)[0].values, (std::vector<double>{0.0, 2e-9, 4e-9}));
    EXPECT_EQ(timeScales(manifest)[0].said(1), "t = 2 ns");
    plot.mutable_steps(2)->set_time(std::numeric_limits<double>::infinity());
    EXPECT_TRUE(timeScales(manifest).empty());
    plot.add_statistic_names("mean_x");
    plot.add_statistic_names("mean_z");
    for (int i = 0; i < 3; ++i) {
        plot.mutable_steps(i)->set_iteration(100 * i);
        plot.mutable_steps(i)->mutable_statistics()->Add(0.0);
        plot.mutable_steps(i)->mutable_statistics()->Add(-0.5 * i);  // backwards
    }
    const auto scales = timeScales(manifest);
    ASSERT_EQ(scales.size(), 2U);
    EXPECT_EQ(scales[0].said(2), "iteration 200");
    EXPECT_EQ(scales[1].name, "position");
    EXPECT_EQ(scales[1].said(1), "z = -0.5 m");
}

TEST(TimeBar, NumbersOfStepsAreNoTime) {
    proto::Manifest manifest;
    for (int i = 0; i < 3; ++i) manifest.mutable_hybrid()->add_steps()->set_time(i);
    EXPECT_TRUE(timeScales(manifest).empty());
    manifest.mutable_hybrid()->mutable_steps(2)->set_time(2.5);
    EXPECT_EQ(timeScales(manifest).at(0).name, "time");
}

TEST(ViewModel, AStyleGoesFromLayerToLayer) {
    ViewModel model;
    ASSERT_TRUE(model.load(savedView()).ok());
    const auto style = model.style();
    EXPECT_EQ(style.dataset(), "");
    EXPECT_EQ(style.particles().points().opacity(), 0.25);
    model.choose(1);
    ASSERT_TRUE(model.setStyle(style).ok());
    EXPECT_EQ(model.edited().layers(1).particles().volume().color_map(), "viridis");
    EXPECT_EQ(model.edited().layers(1).dataset(), "data/other");
    proto::Layer other;
    other.mutable_mesh();
    EXPECT_FALSE(model.setStyle(other).ok());
    auto bad = style;
    bad.mutable_particles()->mutable_points()->set_opacity(7.0);
    EXPECT_FALSE(model.setStyle(bad).ok());
    EXPECT_EQ(model.edited().layers(1).particles().points().opacity(), 0.25);
}

TEST(Playback, IsStillWhereThereIsNothingToPlay) {
    auto playback = playing();
    EXPECT_EQ(playback.next(20.0, 0, 1, true), std::nullopt);
    EXPECT_EQ(playback.next(20.0, 0, 0, true), std::nullopt);
    playback.playing = false;
    EXPECT_EQ(playback.next(20.0, 0, 5, true), std::nullopt);
}

TEST(ViewFiles, ANameThatIsOfferedIsFree) {
    const test::TempDir folder;
    const auto usual = folder / "view.json";
    EXPECT_EQ(freshPath(usual), usual);
    std::ofstream(usual) << "{}";
    EXPECT_EQ(freshPath(usual), folder / "view-2.json");
    std::filesystem::create_symlink("nowhere", folder / "view-2.json");
    EXPECT_EQ(freshPath(usual), folder / "view-3.json");
}

proto::Description described(const std::string& dataset, const AxisNames& axes) {
    proto::Description description;
    description.set_dataset(dataset);
    for (const auto& axis : axes)
        description.mutable_manifest()->mutable_particles()->add_axes()->set_name(axis);
    auto& particles = *description.mutable_replot()->mutable_particles();
    particles.add_inputs("data/run.h5");
    for (const auto& axis : axes) particles.add_axes(axis);
    particles.add_bounds()->set_name("x");
    particles.set_leaf_capacity(64);
    return description;
}

TEST(Replot, KeepsTheRunAndItsOptionsAndChangesTheAxes) {
    const auto request = replotRequest(described("data/beam", {"x", "px", "y"}), {"x", "y", "z"});
    ASSERT_TRUE(request);
    EXPECT_EQ(request->output(), "data/beam-x-y-z.mote");
    EXPECT_EQ(request->particles().inputs(0), "data/run.h5");
    EXPECT_EQ(request->particles().axes(2), "z");
    EXPECT_EQ(request->particles().leaf_capacity(), 64U);
    EXPECT_EQ(request->particles().bounds_size(), 0);
    EXPECT_EQ(datasetName(*request), "data/beam-x-y-z");
}

TEST(Replot, BoundsOfEachStepStayTheirs) {
    auto description = described("data/beam", {"x", "px", "y"});
    EXPECT_EQ(replotRequest(description, {"x", "y", "z"})->particles().bounds_of(), "");
    auto& particles = *description.mutable_replot()->mutable_particles();
    particles.mutable_bounds(0)->set_unit("step");  // as requests said before bounds_of
    EXPECT_EQ(replotRequest(description, {"x", "y", "z"})->particles().bounds_of(), "step");
    particles.clear_bounds();
    particles.set_bounds_of("step");
    EXPECT_EQ(replotRequest(description, {"x", "y", "z"})->particles().bounds_of(), "step");
}

TEST(Replot, NamesDoNotGrow) {
    const auto request = replotRequest(described("data/beam-x-y-z", {"x", "y", "z"}), {"x", "px", "y"});
    ASSERT_TRUE(request);
    EXPECT_EQ(request->output(), "data/beam-x-px-y.mote");
}

TEST(Replot, NothingWhereTheRunIsOutOfReach) {
    auto description = described("data/beam", {"x", "px", "y"});
    description.clear_replot();
    EXPECT_FALSE(replotRequest(description, {"x", "y", "z"}));
    EXPECT_FALSE(axesOf(proto::Description()));
}

std::string shown(double value, double span) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), formatFor(span, value).c_str(), value);
    return text.data();
}

TEST(FormatFor, TellsNumbersApartThatLieFarFromZero) {
    EXPECT_EQ(shown(0.5, 1.0), "0.5");
    EXPECT_EQ(shown(101325.001, 0.001), "101325.001");
    EXPECT_NE(shown(101325.0011, 0.001), shown(101325.0012, 0.001));
    EXPECT_EQ(shown(1234567.0, 1e9), "1.235e+06");
}

TEST(FormatFor, IsAFormatWhateverTheSpan) {
    for (const double span : {0.0, -1.0, 1e-300, 1e300, std::numeric_limits<double>::infinity()}) {
        EXPECT_NO_THROW(shown(7.0, span));
        EXPECT_FALSE(shown(0.0, span).empty());
    }
}

TEST(SliderValues, AFloatIsTheDecimalThatItShows) {
    EXPECT_EQ(decimal(0.1F), 0.1);
    EXPECT_EQ(decimal(3.0F), 3.0);
    EXPECT_EQ(share(0.3F), 0.3);
    EXPECT_EQ(share(1.5F), 1.0);
    EXPECT_EQ(decimal(1e-30F), 1e-30);
}

}  // namespace
}  // namespace mote::client
