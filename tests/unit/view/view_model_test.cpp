// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/view_model.h"

#include <gtest/gtest.h>

#include "protocol/scene/json.h"
#include "protocol/scene/view.h"

namespace mote::client {
namespace {

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
    model.setDataset("data/beam", 3);
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
    EXPECT_FALSE(model.load(proto::View()).ok());
}

TEST(ViewModel, AnotherDatasetKeepsTheLookAndAStepThatExists) {
    ViewModel model;
    ASSERT_TRUE(model.load(savedView()).ok());
    model.setDataset("data/short", 2);
    EXPECT_EQ(model.step(), 1U);
    EXPECT_EQ(model.colorMap, "viridis");
}

TEST(ViewModel, TheCameraFitsUntilItIsMoved) {
    ViewModel model;
    EXPECT_NE(model.camera(0.5), model.camera(2.0));
    model.setCamera(model.camera(2.0));
    EXPECT_EQ(model.camera(0.5), model.camera(2.0));
    model.fit();
    EXPECT_NE(model.camera(0.5), model.camera(2.0));
}

}  // namespace
}  // namespace mote::client
