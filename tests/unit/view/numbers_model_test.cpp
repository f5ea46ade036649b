// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/numbers_model.h"

#include <gtest/gtest.h>

#include "client/view/numbers/quantities.h"
#include "protocol/scene/json.h"
#include "protocol/scene/paths.h"
#include "protocol/scene/view.h"

namespace mote::client {
namespace {

proto::View viewOf(const std::string& json) {
    proto::View view;
    const auto status = parseJson(json, view, "test");
    EXPECT_TRUE(status.ok()) << status.error().toString();
    return view;
}

proto::View fullView() {
    return viewOf(R"({"width": 64, "height": 48,
        "selections": [{"name": "halo", "selection": {"density": {"max": 0.4}, "step": 3}},
                       {"name": "core", "selection": {"not": {"named": "halo"}}}],
        "annotations": {"axes": true, "labels": true, "title": "t", "fontPoints": 11},
        "layers": [{"dataset": "data/beam", "particles": {},
                    "colorBy": {"column": "px", "range": [-1, 2], "colorMap": "inferno", "ofPixel": "nearest"},
                    "select": {"named": "core"},
                    "highlight": {"selection": {"named": "halo"}, "color": [1, 0, 0.5], "sizePixels": 3,
                                  "opacity": 0.5},
                    "paths": {"ids": ["4", "18446744073709551615"], "color": [0, 1, 0], "width": 2}},
                   {"dataset": "data/beam", "particles": {}}, {"dataset": "data/other", "particles": {}}]})");
}

proto::Selection range(const std::string& column) {
    proto::Selection selection;
    auto& added = *selection.add_ranges();
    added.set_column(column);
    added.set_min(0.5);
    return selection;
}

TEST(NumbersModel, WhatSelectsNothingStaysSo) {
    auto view =
        viewOf(R"({"width": 64, "height": 48, "selections": [{"name": "none", "selection": {"any": []}}],
        "layers": [{"dataset": "data/beam", "particles": {}, "select": {"ids": []},
                    "highlight": {"selection": {"named": "none"}}}]})");
    NumbersModel model;
    model.read(view);
    model.write(view);
    const auto parsed = parseView(view);
    ASSERT_TRUE(parsed.ok()) << parsed.error().toString();
    EXPECT_TRUE(parsed->layers[0].select->nothing);
    EXPECT_TRUE(parsed->layers[0].highlight->selection.nothing);
    EXPECT_TRUE(model.chosenWhole()->nothing());
    ASSERT_TRUE(model.take(range("x"), Combine::either, "wish").ok());
    EXPECT_EQ(model.chosenWhole()->any_size(), 2);
    EXPECT_TRUE(model.chosenWhole()->any(0).nothing());
}

TEST(NumbersModel, WhatAViewHasIsWrittenAsItWas) {
    NumbersModel model;
    model.read(fullView());
    auto written = fullView();
    model.write(written);
    const auto before = parseView(fullView()), after = parseView(written);
    ASSERT_TRUE(before.ok()) << before.error().toString();
    ASSERT_TRUE(after.ok()) << after.error().toString();
    EXPECT_EQ(after->selections, before->selections);
    EXPECT_EQ(after->annotations, before->annotations);
    EXPECT_EQ(after->layers[0].colorBy, before->layers[0].colorBy);
    EXPECT_EQ(after->layers[0].select, before->layers[0].select);
    EXPECT_EQ(after->layers[0].highlight->selection, before->layers[0].highlight->selection);
    EXPECT_EQ(after->layers[0].highlight->pointSize, before->layers[0].highlight->pointSize);
    EXPECT_EQ(after->layers[0].paths->ids, before->layers[0].paths->ids);
    EXPECT_EQ(after->layers[1], before->layers[1]);
    EXPECT_EQ(after->layers[2], before->layers[2]);
}

TEST(NumbersModel, AViewWithoutNumbersStaysOne) {
    const auto plain =
        viewOf(R"({"width": 64, "height": 48, "layers": [{"dataset": "a/b", "particles": {}}]})");
    NumbersModel model;
    auto written = plain;
    model.write(written);
    EXPECT_EQ(written.SerializeAsString(), plain.SerializeAsString());
}

TEST(NumbersModel, OtherKindsOfLayersHaveNothingOfIt) {
    NumbersModel model;
    model.read(fullView());
    auto view = viewOf(R"({"width": 64, "height": 48, "layers": [{"dataset": "a/b", "ink": {}}]})");
    model.write(view);
    const auto parsed = parseView(view);
    EXPECT_TRUE(parsed.ok()) << parsed.error().toString();
}

TEST(NumbersModel, WhatIsShownByHandIsShownInAllLayersOfTheRun) {
    NumbersModel model;
    model.read(fullView());
    model.highlight("core");
    model.showAlone("");
    auto view = fullView();
    model.write(view);
    EXPECT_EQ(view.layers(0).highlight().selection().named(), "core");
    EXPECT_EQ(view.layers(1).highlight().selection().named(), "core");
    EXPECT_FALSE(view.layers(0).has_select());
    EXPECT_FALSE(view.layers(2).has_highlight());
}

TEST(NumbersModel, ASelectionOfALayersOwnGetsAName) {
    auto view = fullView();
    *view.mutable_layers(0)->mutable_highlight()->mutable_selection() = range("x");
    NumbersModel model;
    model.read(view);
    ASSERT_EQ(model.selections().size(), 3);
    EXPECT_EQ(model.selections()[2].name(), model.highlighted());
    model.write(view);
    EXPECT_EQ(parseView(view).value().layers[0].highlight->selection, parseSelection(range("x")).value());
}

TEST(NumbersModel, EditsThatLeaveNoValidListAreRefused) {
    NumbersModel model;
    model.read(fullView());
    EXPECT_FALSE(model.rename(0, "core").ok());
    EXPECT_FALSE(model.rename(0, "").ok());
    EXPECT_FALSE(model.remove(0).ok());  // "core" names it
    EXPECT_FALSE(model.replace(0, reference("core")).ok());
    EXPECT_EQ(model.selections().size(), 2);
    EXPECT_TRUE(model.rename(0, "far").ok());
    EXPECT_EQ(model.highlighted(), "far");
    EXPECT_EQ(model.selections()[1].selection().negated().named(), "far");
    EXPECT_TRUE(model.remove(1).ok());
    EXPECT_EQ(model.alone(), "");
    EXPECT_TRUE(model.remove(0).ok());
    EXPECT_FALSE(model.chosen().has_value());
    EXPECT_FALSE(model.chosenWhole().has_value());
}

TEST(NumbersModel, GesturesMakeAndChangeSelections) {
    NumbersModel model;
    ASSERT_TRUE(model.take(range("x"), Combine::either, "lasso").ok());  // there is none to join
    ASSERT_TRUE(model.take(range("y"), Combine::fresh, "lasso").ok());
    EXPECT_EQ(model.selections()[1].name(), "lasso 2");
    EXPECT_EQ(model.highlighted(), "lasso 2");
    ASSERT_TRUE(model.take(range("px"), Combine::without, "lasso").ok());
    EXPECT_EQ(model.selections().size(), 2);
    EXPECT_EQ(model.chosenWhole()->all_size(), 2);
    auto bad = range("x");
    bad.mutable_ranges(0)->set_max(-1.0);
    EXPECT_FALSE(model.take(bad, Combine::fresh, "bad").ok());
    EXPECT_EQ(model.selections().size(), 2);
}

TEST(NumbersModel, AnotherDatasetIsAskedForNothingThatItHasNot) {
    NumbersModel model;
    model.read(fullView());
    ASSERT_TRUE(model.take(range("pz"), Combine::fresh, "fast").ok());
    proto::ParticlesManifest manifest;
    model.setDataset(manifest);
    EXPECT_EQ(model.colorBy.column, "");
    EXPECT_EQ(model.highlighted(), "");
    EXPECT_EQ(model.alone(), "core");  // of densities alone
    EXPECT_TRUE(model.pathIds().empty());
    EXPECT_EQ(model.selections().size(), 3);
}

TEST(NumbersModel, PathsHaveAnEnd) {
    NumbersModel model;
    for (std::uint64_t id = 0; id < Paths::maxIds; ++id) ASSERT_TRUE(model.addPath(id).ok());
    EXPECT_TRUE(model.addPath(7).ok());  // there already
    EXPECT_FALSE(model.addPath(1 << 20).ok());
    EXPECT_EQ(model.pathIds().size(), static_cast<std::size_t>(Paths::maxIds));
}

TEST(Quantities, AreColumnsAndWhatCanBeMadeOfThem) {
    proto::ParticlesManifest manifest;
    EXPECT_TRUE(quantitiesOf(manifest).empty());
    for (const char* name : {"x", "px", "py", "pz"}) {
        auto& column = *manifest.add_columns();
        column.set_name(name);
        column.set_max(1.0);
    }
    auto quantities = quantitiesOf(manifest);
    EXPECT_NE(findQuantity(quantities, "xp"), nullptr);
    EXPECT_NE(findQuantity(quantities, "p"), nullptr);
    EXPECT_EQ(findQuantity(quantities, "r"), nullptr);
    EXPECT_EQ(findQuantity(quantities, "energy"), nullptr);
    manifest.set_mass(9.4e8);
    quantities = quantitiesOf(manifest);
    EXPECT_NE(findQuantity(quantities, "energy"), nullptr);
    EXPECT_EQ(quantities.front().range, (Interval{0.0, 1.0}));
}

}  // namespace
}  // namespace mote::client
