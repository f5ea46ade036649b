// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/script.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temp_dir.h"

namespace mote::client {
namespace {

using testing::HasSubstr;

class ScriptTest : public testing::Test {
  protected:
    Result<proto::Script> read(const std::string& text) {
        std::ofstream(folder_ / "script.json") << text;
        return readScript(folder_ / "script.json");
    }

    test::TempDir folder_;
};

TEST_F(ScriptTest, ReadsTheExampleOfTheManual) {
    const auto script = read(R"({"views": [{
      "width": 1280, "height": 720, "background": [0, 0, 0],
      "camera": {"eye": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0], "fovYDegrees": 35},
      "layers": [{
        "dataset": "data/beam", "step": 3,
        "particles": {
          "volume": {"curve": [{"density": 0.55, "opacity": 0}, {"density": 0.8, "opacity": 0.2}],
                     "colorMap": "inferno"},
          "points": {"linked": true, "opacity": 0.6, "sizePixels": 1, "color": [1.0, 0.85, 0.6]}
        }}]
    }]})");
    ASSERT_TRUE(script.ok()) << script.error().toString();
    ASSERT_EQ(script->views_size(), 1);
    EXPECT_EQ(script->views(0).layers(0).step(), 3U);
}

struct Bad {
    const char* name;
    const char* text;
    const char* where;  // must be named in the error
    ErrorCode code = ErrorCode::invalidArgument;
};

void PrintTo(const Bad& bad, std::ostream* out) {
    *out << bad.text;
}

class BadScript : public ScriptTest, public testing::WithParamInterface<Bad> {};

TEST_P(BadScript, NamesTheFileAndThePath) {
    const auto views = read(GetParam().text);
    ASSERT_FALSE(views.ok());
    EXPECT_THAT(views.error().toString(), HasSubstr("script.json"));
    EXPECT_THAT(views.error().toString(), HasSubstr(GetParam().where));
    EXPECT_EQ(views.error().code, GetParam().code);
}

constexpr const char* particles = R"({"views": [{"width": 4, "height": 4}, {"width": 4, "height": 4, "layers":
    [{"dataset": "data/a", "particles": {"volume": {"curve": [{"density": 0.5, "opacity": 7}]}}}]}]})";

INSTANTIATE_TEST_SUITE_P(
    Table, BadScript,
    testing::Values(
        Bad{"Empty", "", "script.json"}, Bad{"NoJson", "views: 1", "script.json"},
        Bad{"NoViews", "{}", "views"}, Bad{"EmptyViews", R"({"views": []})", "views"},
        Bad{"UnknownField", R"({"views": [{"width": 4, "height": 4, "heigth": 4}]})", "heigth"},
        Bad{"UnknownTop", R"({"frames": []})", "frames"},
        Bad{"WrongType", R"({"views": [{"width": "wide", "height": 4}]})", "width"},
        Bad{"NoWidth", R"({"views": [{"height": 4}]})", "views[0].width"},
        Bad{"ZeroHeight", R"({"views": [{"width": 4, "height": 0}]})", "views[0].height"},
        Bad{"HugeWidth", R"({"views": [{"width": 100000, "height": 4}]})", "views[0].width"},
        Bad{"TooManyPixels", R"({"views": [{"width": 16384, "height": 16384}]})", "views[0].width"},
        Bad{"BadKnot", particles, "views[1].layers[0].particles.volume.curve[0]"},
        Bad{"NoKind", R"({"views": [{"width": 4, "height": 4, "layers": [{"dataset": "data/a"}]}]})",
            "views[0].layers[0]"},
        Bad{"BadCamera", R"({"views": [{"width": 4, "height": 4, "camera": {"eye": [0, 0]}}]})",
            "views[0].camera.eye"},
        Bad{"NoKeyframes", R"({"keyframes": []})", "script.json"},
        Bad{"OneKeyframe", R"({"fps": 30, "keyframes": [{"seconds": 1, "view": {"width": 4, "height": 4}}]})",
            "keyframes"},
        Bad{"KeyframesInAView", R"({"views": [{"width": 4, "height": 4, "keyframe": []}]})", "keyframe"}),
    [](const auto& each) { return each.param.name; });

TEST_F(ScriptTest, AMissingFileIsNotFound) {
    EXPECT_EQ(readScript(folder_ / "none.json").error().code, ErrorCode::notFound);
    EXPECT_EQ(readScript(folder_.path()).error().code, ErrorCode::invalidArgument);
}

}  // namespace
}  // namespace mote::client
