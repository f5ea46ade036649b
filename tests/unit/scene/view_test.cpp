// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "protocol/base/json.h"
#include "protocol/scene/srgb.h"

namespace mote {
namespace {

proto::View viewMessage(const char* json) {
    proto::View message;
    const auto status = parseJson(json, message, "view");
    EXPECT_TRUE(status.ok()) << status.error().toString();
    return message;
}

proto::View plain() {
    return viewMessage(R"({"width": 640, "height": 360, "background": [0, 0.5, 1],
      "camera": {"eye": [0, 0, 4], "target": [0, 0, 0]},
      "layers": [{"dataset": "data/beam", "step": 2, "particles": {}},
                 {"dataset": "data/other", "particles": {"points": {"opacity": 0.25}},
                  "transform": [2, 0, 0, 5,  0, 3, 0, 6,  0, 0, 4, 7,  0, 0, 0, 1]}]})");
}

TEST(View, IsReadAsItWasWritten) {
    const auto view = parseView(plain());
    ASSERT_TRUE(view.ok()) << view.error().toString();
    EXPECT_EQ(view->width, 640U);
    EXPECT_EQ(view->height, 360U);
    EXPECT_NEAR(view->aspect(), 16.0 / 9.0, 1e-15);
    EXPECT_EQ(view->background, glm::dvec3(0.0, srgbToLinear(0.5), srgbToLinear(1.0)));
    EXPECT_EQ(view->camera, Camera{});
    ASSERT_EQ(view->layers.size(), 2U);
    EXPECT_EQ(view->layers[0].dataset, "data/beam");
    EXPECT_EQ(view->layers[0].step, 2U);
    EXPECT_EQ(view->layers[0].transform, glm::dmat4(1.0));
    EXPECT_EQ(view->layers[1].particles()->points().opacity(), 0.25);
    // Row by row: the fourth column moves.
    EXPECT_EQ(view->layers[1].transform * glm::dvec4(1.0, 1.0, 1.0, 1.0), glm::dvec4(7.0, 9.0, 11.0, 1.0));
}

TEST(View, WithoutACameraSeesItsLayers) {
    auto message = plain();
    message.clear_camera();
    const auto view = parseView(message);
    ASSERT_TRUE(view.ok());
    const Bounds both = plotBounds.united(plotBounds.transformed(view->layers[1].transform));
    EXPECT_EQ(view->camera, fitCamera(both, view->aspect()));
}

TEST(View, WithoutACameraDoesNotSeeLayersOfWhichThereIsNothing) {
    auto message = plain();
    message.clear_camera();
    message.mutable_layers(1)->set_opacity(0.0);
    EXPECT_EQ(parseView(message)->camera, fitCamera(plotBounds, parseView(message)->aspect()));
    message.mutable_layers(0)->set_opacity(0.0);
    EXPECT_EQ(parseView(message)->camera, fitCamera(plotBounds, parseView(message)->aspect()));
    message.mutable_layers(1)->set_opacity(0.5);
    const auto moved = plotBounds.transformed(parseView(message)->layers[1].transform);
    EXPECT_EQ(parseView(message)->camera, fitCamera(moved, parseView(message)->aspect()));
}

TEST(View, ALayersOpacityIsAShare) {
    auto message = plain();
    EXPECT_EQ(parseView(message)->layers[1].opacity, 1.0);
    message.mutable_layers(1)->set_opacity(0.25);
    EXPECT_EQ(parseView(message)->layers[1].opacity, 0.25);
    for (const double wrong : {-1e-9, 1.0 + 1e-9, std::nan("")}) {
        message.mutable_layers(1)->set_opacity(wrong);
        const auto view = parseView(message);
        ASSERT_FALSE(view.ok());
        EXPECT_EQ(view.error().where, "layers[1].opacity");
    }
}

TEST(View, WithoutLayersIsAView) {
    const auto view = parseView(viewMessage(R"({"width": 1, "height": 1})"));
    ASSERT_TRUE(view.ok());
    EXPECT_EQ(view->camera, fitCamera(plotBounds, 1.0));
    EXPECT_EQ(view->background, glm::dvec3(0.0));
}

TEST(View, TheLargestSizesAreAllowed) {
    auto message = plain();
    message.set_width(View::maxSide);
    message.set_height(View::maxPixels / View::maxSide);
    EXPECT_TRUE(parseView(message).ok());
}

struct ViewFault {
    const char* what;
    std::function<void(proto::View&)> spoil;
    const char* where;
};

class BadView : public testing::TestWithParam<ViewFault> {};

TEST_P(BadView, IsAnErrorThatNamesItsField) {
    auto message = plain();
    GetParam().spoil(message);
    const auto result = parseView(message);
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().where, GetParam().where) << result.error().toString();
    EXPECT_FALSE(result.error().message.empty());
}

constexpr double notANumber = std::numeric_limits<double>::quiet_NaN();

proto::ParticlesStyle& style(proto::View& m) {
    return *m.mutable_layers(1)->mutable_particles();
}

INSTANTIATE_TEST_SUITE_P(
    All, BadView,
    testing::Values(
        ViewFault{"noWidth", [](auto& m) { m.clear_width(); }, "width"},
        ViewFault{"noHeight", [](auto& m) { m.clear_height(); }, "height"},
        ViewFault{"tooWide", [](auto& m) { m.set_width(View::maxSide + 1); }, "width"},
        ViewFault{"tooHigh", [](auto& m) { m.set_height(4294967295U); }, "height"},
        ViewFault{"tooManyPixels",
                  [](auto& m) {
                      m.set_width(16384);
                      m.set_height(16384);
                  },
                  "width"},
        ViewFault{"backgroundTooLarge", [](auto& m) { m.set_background(1, 1.5); }, "background[1]"},
        ViewFault{"camera", [](auto& m) { m.mutable_camera()->set_fov_y_degrees(0); }, "camera.fovYDegrees"},
        ViewFault{"emptyCamera", [](auto& m) { m.mutable_camera()->Clear(); }, "camera.eye"},
        ViewFault{"tooManyLayers",
                  [](auto& m) {
                      while (m.layers_size() < 9) *m.add_layers() = m.layers(0);
                  },
                  "layers"},
        ViewFault{"noDataset", [](auto& m) { m.mutable_layers(1)->clear_dataset(); }, "layers[1].dataset"},
        ViewFault{"noKind", [](auto& m) { m.mutable_layers(1)->clear_particles(); }, "layers[1]"},
        ViewFault{"transformShort", [](auto& m) { m.mutable_layers(1)->mutable_transform()->Truncate(12); },
                  "layers[1].transform"},
        ViewFault{"transformNan", [](auto& m) { m.mutable_layers(1)->set_transform(3, notANumber); },
                  "layers[1].transform[3]"},
        ViewFault{"transformTooLarge", [](auto& m) { m.mutable_layers(1)->set_transform(7, 1e10); },
                  "layers[1].transform[7]"},
        ViewFault{"transformProjective", [](auto& m) { m.mutable_layers(1)->set_transform(14, 0.1); },
                  "layers[1].transform"},
        ViewFault{"transformLastOne", [](auto& m) { m.mutable_layers(1)->set_transform(15, 2); },
                  "layers[1].transform"},
        ViewFault{"transformSingular", [](auto& m) { m.mutable_layers(1)->set_transform(5, 0); },
                  "layers[1].transform"},
        ViewFault{"nameTooLong", [](auto& m) { m.mutable_layers(1)->set_name(std::string(201, 'a')); },
                  "layers[1].name"},
        ViewFault{"nameWithAControl", [](auto& m) { m.mutable_layers(1)->set_name("a\nb"); },
                  "layers[1].name"},
        ViewFault{"nameWithALaterControl", [](auto& m) { m.mutable_layers(1)->set_name("a\u0085"); },
                  "layers[1].name"},
        ViewFault{"nameIsNoText", [](auto& m) { m.mutable_layers(1)->set_name("a\xff"); }, "layers[1].name"},
        ViewFault{"hiddenAndWrong",
                  [](auto& m) {
                      m.mutable_layers(1)->set_hidden(true);
                      m.mutable_layers(1)->set_opacity(2.0);
                  },
                  "layers[1].opacity"},
        ViewFault{"curve", [](auto& m) { style(m).mutable_volume()->add_curve()->set_opacity(2); },
                  "layers[1].particles.volume.curve[0]"},
        ViewFault{"pointCurve", [](auto& m) { style(m).mutable_points()->add_curve(); },
                  "layers[1].particles.points.curve"}),
    [](const auto& bad) { return bad.param.what; });

TEST(View, NothingIsThereOfAHiddenLayer) {
    auto message = plain();
    message.clear_camera();
    message.clear_background();
    message.mutable_layers(0)->mutable_ink();
    message.mutable_layers(1)->set_name("ein Kern, \u00e4u\u00dferst dicht");
    message.mutable_layers(1)->set_opacity(0.5);
    const auto all = parseView(message).value();
    message.mutable_layers(1)->set_hidden(true);
    const auto view = parseView(message).value();
    EXPECT_EQ(view.layers[1].opacity, 0.0);
    auto without = message;
    without.mutable_layers()->RemoveLast();
    const auto alone = parseView(without).value();
    EXPECT_EQ(view.camera, alone.camera);
    EXPECT_FALSE(view.camera == all.camera);
    EXPECT_EQ(view.background, alone.background);
    EXPECT_FALSE(view.background == all.background);
    message.mutable_layers(0)->set_hidden(true);
    EXPECT_TRUE(parseView(message).ok());
}

TEST(View, ImagesLeaveThePaperToTheOtherLayers) {
    const auto paper = [](const std::string& layers) {
        const auto text = "{\"width\": 8, \"height\": 8, \"layers\": [" + layers + "]}";
        return parseView(viewMessage(text.c_str()))->background.x;
    };
    const std::string image = R"({"dataset": "a/b", "image": {}})", ink = R"({"dataset": "a/b", "ink": {}})",
                      mesh = R"({"dataset": "a/b", "mesh": {}})";
    EXPECT_EQ(paper(image), 0.0);
    EXPECT_EQ(paper(image + ", " + ink), 1.0);
    EXPECT_EQ(paper(ink + ", " + image + ", " + mesh), 0.0);
}

}  // namespace
}  // namespace mote
