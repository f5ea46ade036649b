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

constexpr const char* savedView = R"({"width": 64, "height": 48, "background": [0.1, 0.2, 0.3],
    "layers": [{"dataset": "data/views", "step": 3, "particles": {}}]})";

TEST_F(ScriptTest, ASavedViewIsAScriptOfOne) {
    const auto script = read(savedView);
    ASSERT_TRUE(script.ok()) << script.error().toString();
    ASSERT_EQ(script->views_size(), 1);
    EXPECT_EQ(script->views(0).layers(0).dataset(), "data/views");
    EXPECT_EQ(script->views(0).background(2), 0.3);
}

TEST_F(ScriptTest, ASavedViewWithoutASizeTakesTheOneThatIsGiven) {
    EXPECT_FALSE(read(R"({"layers": []})").ok());
    const auto script = readScript(folder_ / "script.json", 320, 200);
    ASSERT_TRUE(script.ok()) << script.error().toString();
    EXPECT_EQ(script->views(0).width(), 320U);
    EXPECT_EQ(script->views(0).height(), 200U);
    EXPECT_TRUE(read(R"({"width": 64, "height": 48, "layers": []})").ok());
    EXPECT_EQ(readScript(folder_ / "script.json", 320, 200)->views(0).width(), 64U);
}

/// What is wrong in a view is named as it is in the view.
TEST_F(ScriptTest, ASpoiledSavedViewNamesItsOwnFields) {
    const std::pair<const char*, const char*> bad[] = {
        {R"({"layers": [], "height": 4})", "script.json: width"},
        {R"({"width": 4, "height": 4, "views": 3})", "views"},
        {R"({"\"view\"": 1, "width": 4, "heigth": 4})", "script.json"},
        {R"({"layers": [{"views": 1}]})", "layers[0].views"},
        {R"({"scale": -1, "width": 4, "height": 4})", "script.json: scale"},
        {R"({"width": 4, "height": 4)", "script.json"}};
    for (const auto& [text, where] : bad) {
        const auto script = read(text);
        ASSERT_FALSE(script.ok()) << text;
        EXPECT_THAT(script.error().toString(), HasSubstr(where)) << text;
    }
}

class SavedViewTest : public ScriptTest {
  protected:
    Result<SavedView> open(const std::string& text) {
        std::ofstream(folder_ / "script.json") << text;
        return readSavedView(folder_ / "script.json");
    }
};

TEST_F(SavedViewTest, MayLeaveItsSizeToTheWindow) {
    const auto saved = open(R"({"layers": [{"dataset": "a/b", "particles": {}}]})");
    ASSERT_TRUE(saved.ok()) << saved.error().toString();
    EXPECT_EQ(saved->view.width(), 0U);
    EXPECT_EQ(saved->note, "");
}

TEST_F(SavedViewTest, IsTheFirstOfAScript) {
    const std::string one = savedView, two = R"({"width": 65, "height": 48})";
    const auto alone = open("{\"views\": [" + one + "]}");
    ASSERT_TRUE(alone.ok()) << alone.error().toString();
    EXPECT_EQ(alone->view.width(), 64U);
    EXPECT_EQ(alone->note, "");
    const auto more = open("{\"views\": [" + two + "," + one + "]}");
    ASSERT_TRUE(more.ok()) << more.error().toString();
    EXPECT_EQ(more->view.width(), 65U);
    EXPECT_THAT(more->note, HasSubstr("2 views"));
}

TEST_F(SavedViewTest, SaysWhatOfAFilmItIsNot) {
    const std::string view = savedView;
    const auto keyframes =
        open("{\"keyframes\": [{\"view\": " + view + "}, {\"seconds\": 2, \"view\": " + view + "}]}");
    ASSERT_TRUE(keyframes.ok()) << keyframes.error().toString();
    EXPECT_EQ(keyframes->view.width(), 64U);
    EXPECT_THAT(keyframes->note, HasSubstr("2 keyframes"));
    const auto moves =
        open("{\"view\": " + view + ", \"moves\": [{\"turn\": {\"degrees\": 3}, \"seconds\": 2}]}");
    ASSERT_TRUE(moves.ok()) << moves.error().toString();
    EXPECT_EQ(moves->view.width(), 64U);
    EXPECT_THAT(moves->note, HasSubstr("1 move,"));
    EXPECT_FALSE(open("{}").ok());
    EXPECT_FALSE(open(R"({"views": []})").ok());
}

TEST_F(ScriptTest, AMissingFileIsNotFound) {
    EXPECT_EQ(readScript(folder_ / "none.json").error().code, ErrorCode::notFound);
    EXPECT_EQ(readScript(folder_.path()).error().code, ErrorCode::invalidArgument);
}

}  // namespace
}  // namespace mote::client
