// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/base/json.h"

#include <gtest/gtest.h>

#include <fstream>

#include "protocol/mote.pb.h"
#include "tests/support/temp_dir.h"

namespace mote {
namespace {

TEST(Json, ReadsTheScriptOfTheDocumentation) {
    proto::Script script;
    const auto status = parseJson(R"({"views": [{
      "width": 1280, "height": 720, "background": [0, 0, 0],
      "camera": {"eye": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0], "fovYDegrees": 35},
      "layers": [{"dataset": "data/beam", "step": 3,
        "particles": {
          "volume": {"curve": [{"density": 0.55, "opacity": 0}, {"density": 0.8, "opacity": 0.2}],
                     "colorMap": "inferno"},
          "points": {"linked": true, "opacity": 0.6, "sizePixels": 1, "color": [1.0, 0.85, 0.6]}}}]}]})",
                                  script, "script.json");
    ASSERT_TRUE(status.ok()) << status.error().toString();
    ASSERT_EQ(script.views_size(), 1);
    EXPECT_EQ(script.views(0).layers(0).particles().volume().curve(1).opacity(), 0.2);
    EXPECT_TRUE(script.views(0).layers(0).particles().points().has_linked());
}

/// An error must name the source and, in its text, the field.
void expectNamed(const char* text, const char* field) {
    proto::Script script;
    const auto status = parseJson(text, script, "script.json");
    ASSERT_FALSE(status.ok()) << text;
    EXPECT_EQ(status.error().code, ErrorCode::invalidArgument);
    EXPECT_NE(status.error().toString().find("script.json"), std::string::npos) << status.error().toString();
    EXPECT_NE(status.error().toString().find(field), std::string::npos) << status.error().toString();
}

TEST(Json, AnUnknownFieldIsNamedWithItsPath) {
    expectNamed(R"({"views": [{"widht": 3}]})", "views[0].widht");
    expectNamed(R"({"views": [{"width": 3}, {"layers": [{"particles": {"points": {"siez": 1}}}]}]})",
                "views[1].layers[0].particles.points.siez");
    expectNamed(R"({"frames": 30})", "frames");
}

TEST(Json, AHighlightMayBeTheSelectionItself) {
    const auto read = [](const std::string& highlight) {
        proto::Script script;
        const auto status = parseJson(
            R"({"views": [{"layers": [{"highlight": )" + highlight + R"(, "step": 2}]}]})", script, "s");
        EXPECT_TRUE(status.ok()) << highlight << status.error().toString();
        EXPECT_EQ(script.views(0).layers(0).step(), 2U);
        return toJsonLine(script.views(0).layers(0).highlight(), false);
    };
    for (const std::string selection :
         {R"({"density": {"max": 0.4}})", R"({"all": [{"not": {"ids": ["7"]}}, {}]})",
          R"({"step": 3, "ids": []})",
          R"({"polygon": {"columns": ["x", "}\"{"], "points": [[0, 1], [1, 0], [0, 0]]}})"}) {
        EXPECT_EQ(read(selection), read(R"({"selection": )" + selection + "}")) << selection;
    }
    EXPECT_EQ(read("{'ranges': [{column: 'x'}]}"), R"({"selection":{"ranges":[{"column":"x"}]}})");
    EXPECT_EQ(read("{}"), "{}");
    EXPECT_EQ(read(R"({"opacity": 0.5})"), R"({"opacity":0.5})");
    expectNamed(R"({"views": [{"layers": [{"highlight": {"density": {}, "color": [1, 0, 0]}}]}]})",
                "views[0].layers[0].highlight.density");
    expectNamed(R"({"views": [{"layers": [{"highlight": {"colour": [1, 0, 0]}}]}]})",
                "views[0].layers[0].highlight.colour");
}

TEST(Json, AWrongTypeIsNamedWithItsPath) {
    expectNamed(R"({"views": [{"width": "wide"}]})", "views[0].width");
    expectNamed(R"({"views": [{"width": -1}]})", "views[0].width");
    expectNamed(R"({"views": [{"width": 1.5}]})", "views[0].width");
    expectNamed(R"({"views": [{"camera": {"eye": [0, "x", 0]}}]})", "views[0].camera.eye[1]");
    expectNamed(R"({"views": [{"layers": [{"particles": {"points": {"linked": 3}}}]}]})",
                "views[0].layers[0].particles.points.linked");
    expectNamed(R"({"views": [{"camera": 7}]})", "views[0].camera");
    // As the field is called in JSON, whichever way it was written.
    expectNamed(R"({"views": [{"camera": {"fov_y_degrees": "x"}}]})", "views[0].camera.fovYDegrees");
}

TEST(Json, BrokenTextIsAnError) {
    for (const char* text : {"", "{", "[]", "nothing", "{\"views\": [}", "{} {}", "\xff\xfe"}) {
        proto::Script script;
        EXPECT_FALSE(parseJson(text, script, "s").ok()) << text;
    }
}

std::string complaintAbout(const char* text) {
    proto::Script script;
    const auto status = parseJson(text, script, "script.json");
    return status.ok() ? std::string() : status.error().message;
}

TEST(Json, WhereTextIsBrokenIsTold) {
    EXPECT_EQ(complaintAbout("{\n \"views\": [\n  {\"width\": 3 \"height\": 4}]}\n"),
              "line 3, column 15: a comma or } is missing here");
    EXPECT_EQ(complaintAbout("{\"views\": [}"), "line 1, column 12: a value is missing here");
    EXPECT_EQ(complaintAbout(""), "is empty; what is wanted is JSON, which begins with {");
    EXPECT_EQ(complaintAbout("no json"), "line 1, column 1: a value is missing here");
    EXPECT_EQ(complaintAbout("{\"views\" 3}"), "line 1, column 10: a colon is missing here");
    EXPECT_EQ(complaintAbout("{\"fps\": 3"), "line 1, column 10: a comma or } is missing here");
    EXPECT_EQ(complaintAbout("{\"fps\": 3} 4"), "line 1, column 12: nothing more may stand here");
    EXPECT_EQ(complaintAbout("{\"fps\": \"3}"), "line 1, column 9: a text begins that does not end here");
}

TEST(Json, WhatAFieldTakesIsToldInPlainWords) {
    EXPECT_EQ(complaintAbout(R"({"views": [{"width": "wide"}]})"),
              "views[0].width: \"wide\" is not a whole number from 0 on");
    EXPECT_EQ(complaintAbout(R"({"views": [{"layers": [{"dataset": 5}]}]})"),
              "views[0].layers[0].dataset: 5 is not a text in quotes");
    EXPECT_EQ(complaintAbout(R"({"views": 3})"), "views: 3 is not a group in braces {}");
    EXPECT_EQ(complaintAbout("[1]"), "a group in braces {} must stand here");
    EXPECT_EQ(complaintAbout(R"({"views": [{"layers": [{"mesh": {}, "ink": {}}]}]})"),
              "views[0].layers[0]: it has another kind already, and cannot be \"ink\" too");
    EXPECT_EQ(complaintAbout(R"({"views": [{"widht": 3}]})"),
              "views[0].widht: there is no such field; near it: width");
    EXPECT_EQ(complaintAbout(R"({"views": [{"layers": [{}, {"particle": {}}]}]})"),
              "views[0].layers[1].particle: there is no such field; near it: particles");
    EXPECT_EQ(complaintAbout(R"({"views": [{"camera": {"fovY": 3}}]})"),
              "views[0].camera.fovY: there is no such field; near it: fovYDegrees");
    EXPECT_EQ(complaintAbout(R"({"qqq": 1})"), "qqq: there is no such field");
}

TEST(Json, DeepNestingIsAnErrorAndNoCrash) {
    proto::Script script;
    EXPECT_FALSE(parseJson(std::string(1000000, '['), script, "s").ok());
    std::string deep;
    for (int i = 0; i < 100000; ++i) deep += "{\"views\":[";
    EXPECT_FALSE(parseJson(deep, script, "s").ok());
}

TEST(Json, WhatIsWrittenIsReadAgain) {
    proto::View view;
    view.set_width(7);
    view.add_background(0.1);
    view.add_layers()->set_dataset("a/\"b\"\n\xc3\xa9");
    for (const auto& text : {toJson(view), toJsonLine(view), toJsonLine(view, true)}) {
        proto::View again;
        const auto status = parseJson(text, again, "s");
        ASSERT_TRUE(status.ok()) << status.error().toString();
        EXPECT_EQ(again.SerializeAsString(), view.SerializeAsString()) << text;
    }
    EXPECT_EQ(toJson(view).back(), '\n');
    EXPECT_EQ(toJsonLine(view).find('\n'), std::string::npos);
    EXPECT_EQ(toJsonLine(view).find("height"), std::string::npos);
    EXPECT_NE(toJsonLine(view, true).find("height"), std::string::npos);
}

TEST(JsonFile, IsReadUpToItsLimit) {
    const test::TempDir folder;
    const std::string text = R"({"width": 5})";
    std::ofstream(folder / "view.json") << text;
    proto::View view;
    ASSERT_TRUE(readJsonFile(folder / "view.json", view, text.size()).ok());
    EXPECT_EQ(view.width(), 5U);
    const auto tooLarge = readJsonFile(folder / "view.json", view, text.size() - 1);
    ASSERT_FALSE(tooLarge.ok());
    EXPECT_EQ(tooLarge.error().code, ErrorCode::resourceExhausted);
    EXPECT_EQ(tooLarge.error().where, (folder / "view.json").string());
}

TEST(JsonFile, WhatCannotBeReadIsAnError) {
    const test::TempDir folder;
    proto::View view;
    EXPECT_EQ(readJsonFile(folder / "absent.json", view).error().code, ErrorCode::notFound);
    EXPECT_EQ(readJsonFile(folder.path(), view).error().code, ErrorCode::invalidArgument);
    std::ofstream(folder / "bad.json") << "{\"widht\": 1}";
    const auto bad = readJsonFile(folder / "bad.json", view);
    EXPECT_EQ(bad.error().code, ErrorCode::invalidArgument);
    EXPECT_NE(bad.error().toString().find((folder / "bad.json").string()), std::string::npos);
    EXPECT_NE(bad.error().toString().find("widht"), std::string::npos);
    const auto told = [&](const std::string& content) {
        std::ofstream(folder / "other.json", std::ios::binary) << content;
        const auto read = readJsonFile(folder / "other.json", view);
        EXPECT_EQ(read.error().code, ErrorCode::invalidArgument);
        return read.error().message;
    };
    EXPECT_EQ(told(" \n"), "is empty; what is wanted is JSON, which begins with {");
    EXPECT_EQ(told("\x89HDF\r\n\x1a\n"), "is no text; what is wanted is JSON, which begins with {");
}

}  // namespace
}  // namespace mote
