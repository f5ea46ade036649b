// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is wrong with a script is one sentence, which names the field.
#include <gtest/gtest.h>

#include <limits>

#include "protocol/scene/film/sized_script.h"
#include "protocol/scene/view_message.h"
#include "tests/unit/scene/film_scripts.h"

namespace mote::test {
namespace {

constexpr std::string_view view =
    "{'width': 8, 'height': 8, 'layers': [{'dataset': 'a/b', 'particles': {}}]}";

/// The script with VIEW put where it says so.
proto::Script withViews(std::string text) {
    for (auto at = text.find("VIEW"); at != std::string::npos; at = text.find("VIEW", at))
        text.replace(at, 4, view);
    return scriptOf(text);
}

std::string errorOf(const proto::Script& script) {
    const auto film = Film::create(script, {{"a/b", {plotBounds, 5}}, {"a/mesh", {}}});
    return film.ok() ? "" : film.error().toString();
}

TEST(FilmScript, SaysWhatIsWrong) {
    const std::pair<const char*, const char*> wrong[] = {
        {"{}", "views: a script needs at least one view, or keyframes, or a view and its moves"},
        {"{'views': [VIEW], 'keyframes': [{'view': VIEW}]}",
         "keyframes: a script is made of views, or of keyframes, or of a view and its moves, not of several "
         "of them"},
        {"{'views': [VIEW], 'moves': [{'seconds': 1, 'hold': {}}]}",
         "moves: a script is made of views, or of keyframes, or of a view and its moves, not of several of "
         "them"},
        {"{'view': VIEW, 'keyframes': [{'view': VIEW}]}",
         "keyframes: a script is made of views, or of keyframes, or of a view and its moves, not of several "
         "of them"},
        {"{'moves': [{'seconds': 1, 'hold': {}}]}", "view: moves need a view where they begin"},
        {"{'view': VIEW}", "moves: a film of a view needs at least one move"},
        {"{'keyframes': [{'view': VIEW}]}", "keyframes: a film needs at least two keyframes"},
        {"{'keyframes': [{'view': VIEW}, {'seconds': 0, 'view': VIEW}]}",
         "keyframes[1].seconds: 0 does not lie after 0, the time of the keyframe before"},
        {"{'keyframes': [{'seconds': 2, 'view': VIEW}, {'seconds': 1, 'view': VIEW}]}",
         "keyframes[1].seconds: 1 does not lie after 2, the time of the keyframe before"},
        {"{'keyframes': [{'view': VIEW}, {'seconds': 'NaN', 'view': VIEW}]}",
         "keyframes[1].seconds: nan is not a number from -1000000000 to 1000000000"},
        {"{'keyframes': [{'view': VIEW}, {'seconds': 'Infinity', 'view': VIEW}]}",
         "keyframes[1].seconds: inf is not a number from -1000000000 to 1000000000"},
        {"{'keyframes': [{'view': VIEW}, {'seconds': 1}]}", "keyframes[1].view: a keyframe needs a view"},
        {"{'keyframes': [{'view': VIEW}, {'seconds': 1, 'view': {'width': 8}}]}",
         "keyframes[1].view.height: is missing: a picture has 1 to 16384 pixels a side"},
        {"{'keyframes': [{'view': VIEW}, {'seconds': 1, 'view': {'width': 8, 'height': 9}}]}",
         "keyframes[1].view.height: all keyframes have one size, 8 x 8 as the first, not 8 x 9"},
        {"{'keyframes': [{'view': VIEW}, {'seconds': 1, 'view': {'width': 9, 'height': 8}}]}",
         "keyframes[1].view.width: all keyframes have one size, 8 x 8 as the first, not 9 x 8"},
        {"{'keyframes': [{'view': VIEW, 'easing': 'slow'}, {'seconds': 1, 'view': VIEW}]}",
         "keyframes[0].easing: there are \"linear\", \"smooth\" and \"hold\""},
        {"{'constantSpeed': true, 'keyframes': [{'view': VIEW}, {'seconds': 1, 'view': VIEW, 'easing': "
         "'hold'}]}",
         "keyframes[1].easing: a film of constantSpeed has no easing but \"linear\""},
        {"{'constantSpeed': true, 'views': [VIEW]}",
         "constantSpeed: is of the camera's way through keyframes, and there are none"},
        {"{'betweenSteps': 'mix', 'views': [VIEW]}", "betweenSteps: there are \"hold\" and \"blend\""},
        {"{'fps': 0, 'views': [VIEW]}", "fps: 0 is not a number from 0.001 to 1000"},
        {"{'fps': 1001, 'views': [VIEW]}", "fps: 1001 is not a number from 0.001 to 1000"},
        {"{'fps': 'NaN', 'views': [VIEW]}", "fps: nan is not a number from 0.001 to 1000"},
        {"{'fps': 1000, 'keyframes': [{'view': VIEW}, {'seconds': 1000, 'view': VIEW}]}",
         "keyframes[1].seconds: a film has at most 1000000 frames, not 1000001"},
        {"{'fps': 1000, 'keyframes': [{'seconds': -1e9, 'view': VIEW}, {'seconds': 1e9, 'view': VIEW}]}",
         "keyframes[1].seconds: a film has at most 1000000 frames, not 2000000000001"},
        {"{'view': VIEW, 'moves': [{'seconds': 1e9, 'hold': {}}]}",
         "moves: a film has at most 1000000 frames, not 30000000000"},
        {"{'view': VIEW, 'moves': [{'seconds': 0.01, 'hold': {}}]}",
         "moves: at this rate the film has 0 frames"},
        {"{'view': VIEW, 'moves': [{'hold': {}}]}", "moves[0].seconds: a move takes longer than 0 seconds"},
        {"{'view': VIEW, 'moves': [{'seconds': -1, 'hold': {}}]}",
         "moves[0].seconds: -1 is not a number from 0 to 1000000000"},
        {"{'view': VIEW, 'moves': [{'seconds': 1}]}",
         "moves[0]: a move needs one of \"turn\", \"playSteps\", \"zoomTo\" and \"hold\""},
        {"{'view': VIEW, 'moves': [{'seconds': 1, 'hold': {}, 'turn': {'degrees': 1}}]}",
         "moves[0].hold: what holds does nothing else at once"},
        {"{'view': VIEW, 'moves': [{'seconds': 1, 'hold': {}, 'easing': 'hold'}]}",
         "moves[0].easing: there are \"linear\" and \"smooth\""},
        {"{'view': VIEW, 'moves': [{'seconds': 1, 'turn': {'degrees': 'NaN'}}]}",
         "moves[0].turn.degrees: nan is not a number from -1000000 to 1000000"},
        {"{'view': VIEW, 'moves': [{'seconds': 1, 'hold': {}}, {'seconds': 1, 'turn': {'axis': [0, 0, 0]}}]}",
         "moves[1].turn.axis: an axis must not be zero"},
        {"{'view': VIEW, 'moves': [{'seconds': 1, 'turn': {'axis': [1, 0]}}]}",
         "moves[0].turn.axis: three numbers are needed, not 2"},
        {"{'view': VIEW, 'moves': [{'seconds': 1, 'zoomTo': {'factor': -1}}]}",
         "moves[0].zoomTo.factor: -1 is not a number from 1e-09 to 1000000000"},
        {"{'view': VIEW, 'moves': [{'seconds': 1, 'zoomTo': {'target': [1]}}]}",
         "moves[0].zoomTo.target: three numbers are needed, not 1"},
        {"{'views': [VIEW, {'width': 8, 'height': 8, 'layers': [{'dataset': 'a/c', 'particles': {}}]}]}",
         "views[1].layers[0].dataset: there is no dataset \"a/c\"; there are \"a/b\", \"a/mesh\""},
        {"{'view': {'width': 8, 'height': 8, 'layers': [{'dataset': 'a/b', 'step': 5, 'particles': {}}]},"
         "'moves': [{'seconds': 1, 'hold': {}}]}",
         "view.layers[0].step: \"a/b\" has 5 steps, numbered from 0; there is no step 5"},
        {"{'keyframes': [{'view': VIEW}, {'seconds': 1, 'view': {'width': 8, 'height': 8,"
         "'layers': [{'dataset': 'a/mesh', 'stipple': {'image': 'a/c'}}]}}]}",
         "keyframes[1].view.layers[0].stipple.image: there is no dataset \"a/c\"; there are \"a/b\", "
         "\"a/mesh\""},
        {"{'keyframes': [{'view': VIEW}, {'seconds': 1, 'view': {'width': 8, 'height': 8,"
         "'layers': [{'dataset': 'a/mesh', 'step': 1, 'mesh': {}}]}}]}",
         "keyframes[1].view.layers[0].step: \"a/mesh\" has 0 steps, numbered from 0; there is no step 1"},
    };
    for (const auto& [text, error] : wrong) EXPECT_EQ(errorOf(withViews(text)), error) << text;
}

TEST(FilmScript, HasNoMoreKeyframesThanItMay) {
    auto script = withViews("{'fps': 1, 'keyframes': [{'view': VIEW}, {'seconds': 1, 'view': VIEW}]}");
    while (script.keyframes_size() <= maxKeyframes) {
        auto& added = *script.add_keyframes();
        added = script.keyframes(0);
        added.set_seconds(script.keyframes_size());
    }
    EXPECT_EQ(errorOf(script), "keyframes: a film has at most 10000 keyframes, not 10001");
    script.mutable_keyframes()->RemoveLast();
    EXPECT_EQ(errorOf(script), "");
}

TEST(FilmScript, OfConstantSpeedNeverStandsStill) {
    const auto at = [](double seconds, double x) {
        return "{'seconds': " + std::to_string(seconds) +
               ", 'view': {'width': 8, 'height': 8, 'camera': {'target': [0, 0, 0], 'eye': [" +
               std::to_string(x) + ", 1, 4]}}}";
    };
    EXPECT_EQ(errorOf(scriptOf("{'constantSpeed': true, 'keyframes': [" + at(0, 0) + ", " + at(1, 1) + "," +
                               at(2, 1) + ", " + at(3, 2) + "]}")),
              "keyframes[2].view.camera: the camera does not move from keyframes[1] to here, which takes no "
              "time in a "
              "film of constantSpeed");
}

TEST(FilmScript, OfViewsIsThoseViews) {
    const auto script = withViews("{'fps': 10, 'views': [VIEW, {'width': 16, 'height': 4}, VIEW]}");
    const Film film = filmOf(script);
    EXPECT_FALSE(film.continuous());
    EXPECT_EQ(film.frameCount(), 3U);
    EXPECT_EQ(film.width(), 8U);
    EXPECT_EQ(film.secondsOf(2), 0.2);
    EXPECT_NEAR(film.seconds(), 0.3, 1e-12);
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_EQ(film.frame(i).SerializeAsString(), script.views(static_cast<int>(i)).SerializeAsString());
}

TEST(FilmScript, NamesItsDatasetsOnce) {
    const auto script = withViews(
        "{'keyframes': [{'view': VIEW}, {'seconds': 1, 'view': {'width': 8, 'height': 8, 'layers': ["
        "{'dataset': 'a/plane', 'stipple': {'image': 'a/picture'}}, {'dataset': 'a/b', 'ink': {}}]}}]}");
    EXPECT_EQ(datasetsOf(script), (std::vector<std::string>{"a/b", "a/picture", "a/plane"}));
    EXPECT_EQ(datasetsOf(withViews("{'view': VIEW}")), (std::vector<std::string>{"a/b"}));
    EXPECT_TRUE(datasetsOf({}).empty());
}

TEST(FilmScript, HasItsLookAtAnotherSize) {
    const auto script =
        scriptOf("{'views': [{'width': 800, 'height': 600}, {'width': 80, 'height': 100, 'scale': 0.5}]}");
    const auto sized = sizedScript(script, 1600, 1200);
    ASSERT_TRUE(sized.ok());
    EXPECT_EQ(sized->views(0).width(), 1600U);
    EXPECT_EQ(sized->views(0).height(), 1200U);
    EXPECT_EQ(sized->views(0).scale(), 2.0);
    EXPECT_EQ(sized->views(1).scale(), 6.0);
    const auto film =
        sizedScript(withViews("{'keyframes': [{'view': VIEW}, {'seconds': 1, 'view': VIEW}]}"), 16, 4);
    ASSERT_TRUE(film.ok());
    EXPECT_EQ(film->keyframes(1).view().width(), 16U);
    EXPECT_EQ(film->keyframes(1).view().scale(), 0.5);
    const auto moves = sizedScript(withViews("{'view': VIEW, 'moves': [{'seconds': 1, 'hold': {}}]}"), 8, 8);
    ASSERT_TRUE(moves.ok());
    EXPECT_FALSE(moves->view().has_scale());
    EXPECT_EQ(sizedScript(script, 10, 16000).error().where, "views[1].scale");
    EXPECT_EQ(sizedScript(script, 0, 16).error().where, "views[0].width");
}

TEST(FilmScript, AnnotatesViewsThatSayNothingOfIt) {
    const auto script =
        annotatedScript(scriptOf("{'views': [{'width': 4, 'height': 3}, {'width': 4, 'height': 3, "
                                 "'annotations': {'labels': true}}]}"));
    EXPECT_TRUE(script.views(0).annotations().axes() && script.views(0).annotations().color_bar());
    EXPECT_TRUE(script.views(0).annotations().scale_bar() && script.views(0).annotations().labels());
    EXPECT_TRUE(script.views(1).annotations().labels() && !script.views(1).annotations().axes());
    const auto film = annotatedScript(scriptOf(
        "{'keyframes': [{'view': {'width': 4, 'height': 3}}, {'seconds': 1, 'view': {'width': 4, 'height': "
        "3}}]}"));
    EXPECT_TRUE(film.keyframes(1).view().annotations().axes());
}

TEST(FilmScript, AxesStandStillWhereAFilmGoesThroughSteps) {
    const auto around = [](const std::string& text) {
        const auto script = withStillAxes(withViews(text));
        const auto& first = script.keyframes().empty() ? script.view() : script.keyframes(0).view();
        return first.annotations().axes_around();
    };
    const std::string axes =
                          "{'width': 8, 'height': 8, 'annotations': {'axes': true}, 'layers': "
                          "[{'dataset': 'a/b', 'particles': {}",
                      play = "'moves': [{'seconds': 1, 'playSteps': {'from': 0, 'to': 3}}]}";
    EXPECT_EQ(around("{'view': " + axes + "}]}, " + play), "plot");
    EXPECT_EQ(around("{'view': " + axes + "}]}, 'moves': [{'seconds': 1, 'hold': {}}]}"), "");
    EXPECT_EQ(around("{'view': VIEW, " + play), "");
    EXPECT_EQ(around("{'view': {'annotations': {'axes': true, 'axesAround': 'shown'}}, " + play), "shown");
    const auto keyframes = [&](const std::string& last) {
        return "{'keyframes': [{'view': " + axes + "}]}}, {'seconds': 1, 'view': " + axes + last + "}]}}]}";
    };
    EXPECT_EQ(around(keyframes("")), "");
    EXPECT_EQ(around(keyframes(", 'step': 2")), "plot");
}

/// What one view says and the other leaves out has something in between, and so do two scales.
TEST(FilmScript, MixesLengthsAsPixels) {
    const auto film = filmOf(scriptOf(
        "{'fps': 1, 'keyframes': [{'view': {'width': 100, 'height': 1440, 'annotations': {},"
        "'layers': [{'dataset': 'a/mesh', 'stipple': {}}]}},"
        "{'seconds': 2, 'view': {'width': 100, 'height': 1440, 'scale': 4, 'annotations': {'fontPoints': 9},"
        "'layers': [{'dataset': 'a/mesh', 'stipple': {'spacingPixels': 5}}]}}]}"));
    const auto between = lengthsInPixels(parseView(film.frame(1)).value());
    EXPECT_DOUBLE_EQ(between.layers[0].stipple()->spacing_pixels(), 12.6);
    EXPECT_DOUBLE_EQ(between.layers[0].stipple()->dot_pixels(), 3.6);
    EXPECT_NEAR(fontPixels(*between.annotations, 100, 1440, 1.0), 32.0, 1e-9);
    EXPECT_EQ(film.frame(2).scale(), 4.0);
}

}  // namespace
}  // namespace mote::test
