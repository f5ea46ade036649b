// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a view says beside its styles: colours by a column, selections, highlights, paths, annotations.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "protocol/base/json.h"
#include "protocol/scene/film/layers_between.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/view.h"
#include "protocol/scene/view_message.h"
#include "tests/support/view_text.h"

namespace mote::test {
namespace {

std::string replaced(std::string json) {
    std::replace(json.begin(), json.end(), '\'', '"');
    return json;
}

/// Of a layer of a kind with more fields.
proto::View viewWith(const std::string& kind, const std::string& fields, const std::string& rest = "") {
    proto::View message;
    const auto parsed = parseJson(replaced("{'width': 80, 'height': 60, 'layers': [{'dataset': 'a/b', '" +
                                           kind + "': {}, " + fields + "}]" + rest + "}"),
                                  message, "view");
    EXPECT_TRUE(parsed.ok()) << parsed.error().toString();
    return message;
}

std::string refusalOf(const proto::View& message) {
    const auto parsed = parseView(message);
    EXPECT_FALSE(parsed.ok()) << toJson(message);
    return parsed.ok() ? "" : parsed.error().toString();
}

std::string refusalOf(const std::string& fields) {
    return refusalOf(viewWith("particles", fields));
}

TEST(LayerParts, HaveTheirDefaults) {
    const auto view = parseView(viewWith("particles",
                                         "'colorBy': {'column': 'energy'}, 'select': {'ids': [1]},"
                                         "'highlight': {'selection': {'density': {'max': 0.2}}},"
                                         "'paths': {'ids': [9, 4, 9]}"))
                          .value();
    const auto& layer = view.layers[0];
    EXPECT_EQ(layer.colorBy->column(), "energy");
    EXPECT_FALSE(colorRangeOf(*layer.colorBy));
    EXPECT_EQ(colorMapOf(*layer.colorBy).name(), "viridis");
    EXPECT_EQ(layer.colorBy->of_pixel(), "");
    EXPECT_EQ(layer.select->ids, std::vector<std::uint64_t>{1});
    EXPECT_EQ(layer.highlight->selection.density->max, 0.2);
    EXPECT_EQ(layer.highlight->color, srgbToLinear(glm::dvec3(0.2, 1.0, 0.6)));
    EXPECT_FALSE(layer.highlight->pointSize);
    EXPECT_EQ(layer.highlight->opacity, ParticlesStyle::opacityLimit);
    EXPECT_THAT(layer.paths->ids(), testing::ElementsAre(4, 9));
    EXPECT_TRUE(layer.paths->color().empty());
    EXPECT_FALSE(layer.paths->has_width());
    EXPECT_FALSE(view.annotations);
}

TEST(LayerParts, PointsThatHideEachOtherHaveTheColorOfTheNearest) {
    const auto ofNearest = [](const std::string& points, const std::string& ofPixel) {
        const auto layer =
            viewOf("{'width': 8, 'height': 8, 'layers': [{'dataset': 'a/b', 'colorBy': {'column': 'x'" +
                   ofPixel + "}, 'particles': {'points': {" + points + "}}}]}")
                .layers[0];
        return colorsOfNearest(*layer.colorBy, particlesStyleOf(*layer.particles()));
    };
    EXPECT_FALSE(ofNearest("", ""));
    EXPECT_FALSE(ofNearest("'opacity': 0.49", ""));
    EXPECT_TRUE(ofNearest("'opacity': 0.5", ""));
    EXPECT_FALSE(ofNearest("'opacity': 1", ", 'ofPixel': 'mean'"));
    EXPECT_TRUE(ofNearest("", ", 'ofPixel': 'nearest'"));
}

TEST(LayerParts, EveryKindCanBeCut) {
    const std::string clip =
        "'clip': {'planes': [{'normal': [0, 3, 4], 'distance': 10}], 'box': {'min': [0, 0, 0], 'max': [1, 2, "
        "3]}}";
    for (const char* kind : {"particles", "hybrid", "mesh", "ink", "stipple"}) {
        const auto view = parseView(viewWith(kind, clip)).value();
        const auto clips = view.layers[0].clips();
        ASSERT_EQ(clips.size(), 7U) << kind;
        EXPECT_EQ(clips[0], (HalfSpace{{0.0, 0.6, 0.8}, 2.0})) << kind;
        EXPECT_TRUE(inAll(clips, {0.5, 2.0, 1.5}));
        EXPECT_FALSE(inAll(clips, {0.5, 1.0, 1.0}));
        EXPECT_FALSE(inAll(clips, {1.5, 2.0, 1.5}));
        EXPECT_EQ(parseView(toProto(view)).value(), view) << kind;
    }
    auto both = viewWith("hybrid", clip);
    auto& hybrid = *both.mutable_layers(0)->mutable_hybrid();
    *hybrid.add_clip_planes() = both.layers(0).clip().planes(0);
    EXPECT_EQ(parseView(both).value().layers[0].clips().size(), 8U);
    *hybrid.mutable_clip_box() = both.layers(0).clip().box();
    EXPECT_NE(refusalOf(both).find("layers[0].clip.box"), std::string::npos);
}

TEST(LayerParts, PlanesAndBoxMayStandBesideTheClip) {
    const std::string plane = "{'normal': [0, 0, 2], 'distance': 1}",
                      box = "{'min': [0, 0, 0], 'max': [1, 2, 3]}";
    const auto inClip = "'clip': {'planes': [" + plane + "], 'box': " + box + "}";
    for (const char* kind : {"particles", "hybrid", "mesh", "ink", "stipple", "image"}) {
        const auto said = parseView(viewWith(kind, inClip)).value();
        for (const auto& beside : {"'clipPlanes': [" + plane + "], 'clipBox': " + box,
                                   "'clip': {'planes': [" + plane + "]}, 'clipBox': " + box,
                                   "'clip': {'box': " + box + "}, 'clipPlanes': [" + plane + "]"})
            EXPECT_EQ(parseView(viewWith(kind, beside)).value(), said) << kind << " " << beside;
    }
    proto::View picture = viewWith("stipple", "'clip': {'planes': [" + plane + "]}");
    picture.mutable_layers(0)->mutable_stipple()->set_image("a/c");
    EXPECT_TRUE(parseView(picture).ok());
    const auto refused = [](const std::string& part, const std::string& where) {
        EXPECT_EQ(refusalOf(viewWith("mesh", part)).rfind("layers[0]." + where, 0), 0U)
            << refusalOf(viewWith("mesh", part));
    };
    refused("'clip': {'box': " + box + "}, 'clipBox': " + box, "clipBox: ");
    refused("'clipBox': {'min': [0, 0, 0], 'max': [0, 1, 1]}", "clipBox.max[0]: ");
    refused("'clipPlanes': [" + plane + ", {'normal': [0, 0, 0]}]", "clipPlanes[1].normal: ");
    refused("'clipPlanes': [{'distance': 1}]", "clipPlanes[0].normal: ");
    refused("'clip': {'planes': [{'normal': [0, 0, 0]}]}, 'clipPlanes': [" + plane + "]",
            "clip.planes[0].normal: ");
    std::string many = plane;
    for (int i = 0; i < 5; ++i) many += ", " + plane;
    EXPECT_TRUE(parseView(viewWith("mesh", "'clipPlanes': [" + many + "]")).ok());
    refused("'clip': {'planes': [" + plane + "]}, 'clipPlanes': [" + many + "]", "clipPlanes: ");
}

TEST(LayerParts, AnImageHasNoPlace) {
    EXPECT_TRUE(parseView(viewWith("image", "'opacity': 0.5")).ok());
    const auto refused = [](const std::string& part, const std::string& where) {
        EXPECT_EQ(refusalOf(viewWith("image", part)).rfind("layers[0]." + where, 0), 0U)
            << refusalOf(viewWith("image", part));
    };
    refused("'transform': [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]", "transform");
    refused("'select': {'ranges': [{'column': 'x', 'min': 0}]}", "select");
    refused("'colorBy': {'column': 'x'}", "colorBy");
    refused("'towards': {'step': 1, 'share': 0.5}", "towards");
}

TEST(LayerParts, WhatCannotBeCutIsRefused) {
    const auto refused = [](const std::string& clip, const std::string& where) {
        EXPECT_EQ(refusalOf("'clip': " + clip).rfind("layers[0].clip." + where, 0), 0U) << clip;
    };
    refused("{'planes': [{'normal': [1, 0, 0]}, {'normal': [0, 0, 0]}]}", "planes[1].normal");
    refused("{'planes': [{'distance': 1}]}", "planes[0].normal");
    refused("{'box': {'min': [0, 1, 0], 'max': [1, 1, 1]}}", "box.max[1]");
    std::string seven = "{'normal': [1, 0, 0]}";
    for (int i = 0; i < 6; ++i) seven += ", {'normal': [1, 0, 0]}";
    refused("{'planes': [" + seven + "]}", "planes");
}

TEST(LayerParts, AreAbsentFromAViewWithoutThem) {
    const auto view = viewOf("{'width': 8, 'height': 8, 'layers': [{'dataset': 'a/b', 'particles': {}}]}");
    const auto message = toProto(view);
    const auto& layer = message.layers(0);
    EXPECT_FALSE(layer.has_color_by() || layer.has_select() || layer.has_highlight() || layer.has_paths());
    EXPECT_FALSE(layer.has_towards());
    EXPECT_FALSE(message.has_annotations());
    EXPECT_EQ(message.selections_size(), 0);
}

TEST(LayerParts, AreOfParticlesAlone) {
    for (const char* const kind : {"hybrid", "stipple", "ink", "mesh"}) {
        for (const std::string field : {"colorBy", "select", "highlight", "paths"}) {
            EXPECT_EQ(refusalOf(viewWith(kind, "'" + field + "': {}")),
                      "layers[0]." + field + ": only layers of \"particles\" have it");
        }
    }
}

TEST(LayerParts, WhatHasStepsMayBeOnItsWayToAnother) {
    for (const char* const kind : {"particles", "hybrid"}) {
        const auto view =
            parseView(viewWith(kind, "'step': 3, 'towards': {'step': 4, 'share': 0.3}")).value();
        EXPECT_EQ(view.layers[0].towards, (Towards{4, 0.3}));
        EXPECT_EQ(parseView(toProto(view)).value().layers[0].towards, view.layers[0].towards);
        EXPECT_EQ(magnified(view, 2).value().layers[0].towards, view.layers[0].towards);
        EXPECT_EQ(lengthsInPixels(view).layers[0].towards, view.layers[0].towards);
        EXPECT_EQ(parseView(viewWith(kind, "'towards': {}")).value().layers[0].towards, Towards());
        for (const char* const share : {"-0.1", "1.001", "'NaN'"}) {
            EXPECT_EQ(
                refusalOf(viewWith(kind, std::string("'towards': {'share': ") + share + "}")).substr(0, 25),
                "layers[0].towards.share: ");
        }
    }
    for (const char* const kind : {"stipple", "ink", "mesh"}) {
        EXPECT_EQ(refusalOf(viewWith(kind, "'towards': {'step': 1}")),
                  "layers[0].towards: only layers of \"particles\" and \"hybrid\" have it");
    }
}

TEST(LayerParts, SayWhichFieldIsWrong) {
    EXPECT_EQ(refusalOf("'colorBy': {}"), "layers[0].colorBy.column: the name of a column is missing");
    EXPECT_EQ(refusalOf("'colorBy': {'column': 'x', 'range': [1]}"),
              "layers[0].colorBy.range: 2 numbers are needed, not 1");
    EXPECT_EQ(refusalOf("'colorBy': {'column': 'x', 'range': [1, 1]}"),
              "layers[0].colorBy.range: the second value must be the greater one");
    EXPECT_EQ(refusalOf("'colorBy': {'column': 'x', 'range': [0, 'NaN']}").substr(0, 28),
              "layers[0].colorBy.range[1]: ");
    EXPECT_EQ(refusalOf("'colorBy': {'column': 'x', 'colorMap': 'jet'}").substr(0, 28),
              "layers[0].colorBy.colorMap: ");
    EXPECT_EQ(refusalOf("'colorBy': {'column': 'x', 'ofPixel': 'most'}"),
              "layers[0].colorBy.ofPixel: \"most\" is not known: there are mean, nearest");
    EXPECT_EQ(refusalOf("'select': {'polygon': {'columns': ['x', 'y'], 'points': [[0, 0], [1, 1], [2]]}}"),
              "layers[0].select.polygon.points[2]: two numbers are needed");
    EXPECT_EQ(refusalOf("'highlight': {}"),
              "layers[0].highlight.selection: what is to be highlighted is missing");
    EXPECT_EQ(refusalOf("'highlight': {'selection': {'named': 'a'}}"),
              "layers[0].highlight.selection.named: there is no selection \"a\"; none has a name here");
    EXPECT_EQ(refusalOf("'highlight': {'selection': {}, 'sizePixels': 0}"),
              "layers[0].highlight.sizePixels: 0 is not a number from 0.1 to 64");
    EXPECT_EQ(refusalOf("'paths': {'width': 100}"),
              "layers[0].paths.width: 100 is not a number from 0.1 to 64");
    auto many = viewWith("particles", "'paths': {}");
    for (std::uint64_t i = 0; i < 1001; ++i) many.mutable_layers(0)->mutable_paths()->add_ids(i);
    EXPECT_EQ(refusalOf(many), "layers[0].paths.ids: there may be at most 1000, not 1001");
}

TEST(LayerParts, NamesOfTheViewCanBeUsedAndStayWithIt) {
    const auto message = viewWith("particles",
                                  "'select': {'not': {'named': 'halo'}},"
                                  "'highlight': {'selection': {'named': 'halo', 'step': 4}}",
                                  ", 'selections': [{'name': 'halo', 'selection': {'density': {'max': 0.3}}},"
                                  "{'name': 'all'}]");
    const auto view = parseView(message).value();
    ASSERT_EQ(view.selections.size(), 2U);
    EXPECT_TRUE(view.layers[0].select->negated.at(0) == view.selections[0].selection);
    EXPECT_TRUE(view.layers[0].highlight->selection.all.at(0) == view.selections[0].selection);
    EXPECT_TRUE(view.selections[1].selection.everything());
    EXPECT_EQ(parseView(toProto(view)).value(), view);
    auto wrong = message;
    wrong.mutable_selections(1)->mutable_selection()->set_named("all");
    EXPECT_EQ(refusalOf(wrong), "selections[1].selection.named: the selection \"all\" holds itself");
    wrong = message;
    wrong.mutable_selections(1)->set_name("halo");
    EXPECT_EQ(refusalOf(wrong), "selections[1].name: \"halo\" is given twice");
    wrong = message;
    for (int i = 0; i < 63; ++i) wrong.add_selections()->set_name(std::to_string(i));
    EXPECT_EQ(refusalOf(wrong), "selections: a view has at most 64 of them, not 65");
}

TEST(LayerParts, OfAllLayersHoldNoMoreThanTheyMay) {
    auto message = viewWith("particles", "'select': {'named': 'many'}", ", 'selections': [{'name': 'many'}]");
    for (std::uint64_t i = 0; i < 300000; ++i) message.mutable_selections(0)->mutable_selection()->add_ids(i);
    for (int i = 0; i < 3; ++i) *message.add_layers() = proto::Layer(message.layers(0));
    EXPECT_EQ(refusalOf(message),
              "layers[3]: the selections of all layers have more than 1048576 ids and points");
    for (int i = 0; i < 4; ++i) {
        *message.add_selections() = proto::NamedSelection(message.selections(0));
        message.mutable_selections(i + 1)->set_name(std::to_string(i));
    }
    EXPECT_EQ(refusalOf(message),
              "selections[3].selection: all together have more than 1048576 ids and points");
}

TEST(LayerParts, GrowWithThePicture) {
    const auto view =
        parseView(
            viewWith("particles",
                     "'highlight': {'selection': {}, 'sizePixels': 2}, 'paths': {'ids': [1], 'width': 1.5},"
                     "'colorBy': {'column': 'x', 'range': [0, 2]}",
                     ", 'annotations': {'axes': true, 'fontPoints': 12}"))
            .value();
    const auto scaled = magnified(view, 3).value();
    const auto larger = lengthsInPixels(scaled);
    EXPECT_EQ(larger.layers[0].highlight->pointSize, 6.0);
    EXPECT_EQ(larger.layers[0].paths->width(), 4.5);
    EXPECT_EQ(larger.layers[0].colorBy, view.layers[0].colorBy);
    EXPECT_NEAR(fontPixels(*view.annotations, 80, 60, 1.0), 16.0, 1e-12) << "12 points at 96 pixels an inch";
    EXPECT_NEAR(fontPixels(*scaled.annotations, scaled.width, scaled.height, scaled.scale), 48.0, 1e-12);
    EXPECT_NEAR(fontPixels(*larger.annotations, larger.width, larger.height, larger.scale), 48.0, 1e-12);
    EXPECT_NEAR(fontPixels(*magnified(larger, 2).value().annotations, 480, 360, 1.0), 96.0, 1e-12);
    EXPECT_EQ(magnified(view, 1).value(), view);
}

TEST(Annotations, HaveTheirDefaultsAndComeBack) {
    const auto annotationsOf = [](const std::string& json) {
        return *parseView(viewWith("particles", "'step': 0", ", 'annotations': " + json)).value().annotations;
    };
    const auto none = annotationsOf("{}");
    EXPECT_EQ(none, proto::Annotations());
    const auto all = annotationsOf(
        "{'axes': true, 'colorBar': true, 'scaleBar': true, 'labels': true, 'title': 'a title',"
        "'fontPoints': 7.5, 'printWidth': 85, 'color': [1, 0, 1]}");
    EXPECT_TRUE(all.axes() && all.color_bar() && all.scale_bar() && all.labels());
    EXPECT_EQ(all.title(), "a title");
    EXPECT_THAT(all.color(), testing::ElementsAre(1.0, 0.0, 1.0));
    EXPECT_NEAR(fontPixels(all, 850, 600, 1.0), 7.5 / 72.0 * 254.0, 1e-12);
}

TEST(Annotations, SayWhichFieldIsWrong) {
    const auto refusal = [](const std::string& json) {
        return refusalOf(viewWith("particles", "'step': 0", ", 'annotations': " + json));
    };
    EXPECT_EQ(refusal("{'fontPoints': 0}"), "annotations.fontPoints: 0 is not a number from 1 to 200");
    EXPECT_EQ(refusal("{'printWidth': 'NaN'}").substr(0, 24), "annotations.printWidth: ");
    EXPECT_EQ(refusal("{'color': [1, 2, 0]}").substr(0, 22), "annotations.color[1]: ");
    EXPECT_EQ(refusal("{'title': 'two\\nlines'}"), "annotations.title: holds a control character");
    EXPECT_EQ(refusal("{'title': '" + std::string(257, 'a') + "'}"),
              "annotations.title: is longer than 256 bytes");
}

TEST(Annotations, MixTheirNumbers) {
    proto::Annotations small, large;
    small.set_title("from");
    for (int i = 0; i < 3; ++i) small.add_color(0.0);
    large.set_font_points(17.0);
    large.set_title("to");
    const auto mixed = mixAnnotations(small, large, 0.25);
    EXPECT_EQ(mixed->font_points(), 11.0);
    EXPECT_EQ(mixed->title(), "from");
    EXPECT_THAT(mixed->color(), testing::Each(0.0));
    for (int i = 0; i < 3; ++i) large.add_color(1.0);
    EXPECT_THAT(mixAnnotations(small, large, 0.25)->color(),
                testing::Each(testing::DoubleNear(linearToSrgb(0.25), 1e-12)));
    EXPECT_EQ(mixAnnotations(small, std::nullopt, 0.9), small);
    EXPECT_EQ(mixAnnotations(std::nullopt, small, 0.9), std::nullopt);
}

}  // namespace
}  // namespace mote::test
