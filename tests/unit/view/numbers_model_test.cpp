// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/view/numbers/numbers_model.h"
#include "client/view/numbers/quantities.h"
#include "client/view/numbers/selection_edits.h"
#include "protocol/base/json.h"
#include "protocol/scene/layer_parts.h"
#include "protocol/scene/view.h"
#include "tests/support/any_selection.h"

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
    EXPECT_EQ(after->layers[0].paths, before->layers[0].paths);
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
    for (std::uint64_t id = 0; id < mostPathIds; ++id) ASSERT_TRUE(model.addPath(id).ok());
    EXPECT_TRUE(model.addPath(7).ok());  // there already
    EXPECT_FALSE(model.addPath(1 << 20).ok());
    EXPECT_EQ(model.pathIds().size(), static_cast<std::size_t>(mostPathIds));
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

using test::Random;

test::SelectionShape shape() {
    test::SelectionShape any;
    any.columns = {{"x", -1.0, 1.0}, {"px", -5.0, 5.0}, {"energy", 0.0, 9.0}};
    any.ids = 100;
    any.steps = 4;
    any.depth = 2;
    return any;
}

/// A plain reading of a tree of ranges over one number for each column: what a step is does not matter here.
bool holds(const Selection& selection, double x) {
    bool inside = !selection.nothing;
    for (const auto& range : selection.ranges) inside &= x >= range.min && x <= range.max;
    for (const auto& part : selection.all) inside &= holds(part, x);
    bool any = selection.any.empty();
    for (const auto& part : selection.any) any |= holds(part, x);
    for (const auto& part : selection.negated) inside &= !holds(part, x);
    return inside && any;
}

proto::Selection between(double low, double high, int step) {
    proto::Selection selection;
    auto& range = *selection.add_ranges();
    range.set_column("x");
    range.set_min(low);
    range.set_max(high);
    if (step >= 0) selection.set_step(static_cast<std::uint32_t>(step));
    return selection;
}

TEST(SelectionEdits, GesturesCombineAsSetsDo) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        Random random(seed);
        const auto piece = [&] {
            const double low = random.between(-10.0, 10.0);
            auto made = between(low, low + random.between(0.0, 8.0), static_cast<int>(random.below(3)) - 1);
            if (random.chance(0.2)) made.set_nothing(true);
            return made;
        };
        auto selection = piece();
        for (int gesture = 0; gesture < 6; ++gesture) {
            const auto how = random.oneOf({Combine::both, Combine::either, Combine::without});
            const auto added = piece();
            const auto before = parseSelection(selection).value(), with = parseSelection(added).value();
            selection = combined(selection, how, added);
            const auto parsed = parseSelection(selection);
            ASSERT_TRUE(parsed.ok()) << parsed.error().toString();
            for (double x = -12.0; x < 20.0; x += 0.37) {
                const bool one = holds(before, x), other = holds(with, x);
                const bool expected = how == Combine::both     ? one && other
                                      : how == Combine::either ? one || other
                                                               : one && !other;
                ASSERT_EQ(holds(*parsed, x), expected) << seed << " " << x;
            }
        }
    }
}

TEST(SelectionEdits, TheStepOfEachPartStays) {
    const auto same = combined(between(0, 1, 3), Combine::either, between(2, 3, 3));
    EXPECT_EQ(same.step(), 3U);
    EXPECT_FALSE(same.any(0).has_step());
    const auto other = combined(between(0, 1, 3), Combine::either, between(2, 3, 4));
    EXPECT_FALSE(other.has_step());
    EXPECT_EQ(other.any(0).step(), 3U);
    EXPECT_EQ(other.any(1).step(), 4U);
}

TEST(SelectionEdits, ManyGesturesOfOneKindDoNotNest) {
    for (const auto how : {Combine::both, Combine::either, Combine::without}) {
        auto selection = between(0, 1, 2);
        for (int i = 0; i < 60; ++i) selection = combined(selection, how, between(i, i + 1, 5));
        EXPECT_TRUE(parseSelection(selection).ok());
    }
}

TEST(SelectionEdits, WhatAreShapesIsValidAndIsReadAsItWas) {
    Random random(7);
    for (int i = 0; i < 100; ++i) {
        const auto corners = test::anyPolygon(random, {0.0, 0.0}, {1.0, 1.0}, 20);
        proto::Layer layer;
        const auto camera = fitCamera(plotBounds, random.between(0.3, 3.0));
        const auto lasso = parseSelection(lassoOn(camera, 1.5, layer, glm::dmat4(1.0), corners));
        ASSERT_TRUE(lasso.ok()) << lasso.error().toString();
        EXPECT_EQ(lasso->lasso->points, corners);
        const auto message = polygonIn("x", "px", corners);
        EXPECT_EQ(parseSelection(message).value().polygon->points, corners);
        EXPECT_EQ(cornersOf(message.polygon().points()), corners);
    }
}

TEST(SelectionEdits, ALassoSaysItsPlotWhereColumnsTellIt) {
    proto::ParticlesManifest plot;
    for (const char* name : {"x", "px", "r"}) {
        auto& axis = *plot.add_axes();
        axis.set_name(name);
        axis.set_max(2.0);
    }
    for (int step = 0; step < 2; ++step) plot.add_steps();
    proto::Selection::Lasso lasso;
    sayPlot(plot, 0, true, lasso);  // made without columns
    EXPECT_TRUE(lasso.axes().empty());
    for (const char* name : {"x", "y", "px"}) plot.add_columns()->set_name(name);
    sayPlot(plot, 0, false, lasso);
    EXPECT_THAT(lasso.axes(), testing::ElementsAre("x", "px", "r"));
    ASSERT_EQ(lasso.bounds_size(), 3);
    EXPECT_EQ(lasso.bounds(2).values(1).number_value(), 2.0);
    // A step with bounds of its own.
    for (const auto& axis : plot.axes()) *plot.mutable_steps(1)->add_axes() = axis;
    plot.mutable_steps(1)->mutable_axes(0)->set_max(5.0);
    proto::Selection::Lasso own;
    sayPlot(plot, 1, false, own);
    EXPECT_TRUE(own.axes().empty());
    sayPlot(plot, 1, true, own);
    EXPECT_EQ(own.bounds(0).values(1).number_value(), 5.0);
}

TEST(SelectionEdits, NamesAreFollowedAndReplaced) {
    NamedSelectionMessages named;
    for (const char* name : {"a", "b"}) named.Add()->set_name(name);
    *named[0].mutable_selection() = between(0, 1, -1);
    *named[1].mutable_selection()->mutable_negated() = reference("a");
    EXPECT_EQ(namesIn(reference("b"), named), (std::set<std::string>{"a", "b"}));
    EXPECT_EQ(columnsIn(reference("b"), named), std::set<std::string>{"x"});
    EXPECT_EQ(freshName(named, "a"), "a 2");
    EXPECT_EQ(freshName(named, "c"), "c");
    renameIn(*named[1].mutable_selection(), "a", "core");
    EXPECT_EQ(named[1].selection().negated().named(), "core");
    // One that names itself, which no view may have, ends all the same.
    *named[0].mutable_selection() = reference("a");
    EXPECT_EQ(namesIn(reference("a"), named).size(), 1U);
}

TEST(SelectionEdits, AnySelectionIsDescribedInALine) {
    Random random(3);
    for (int i = 0; i < 300; ++i) {
        const auto text = describe(toProto(test::anySelection(random, shape())));
        EXPECT_FALSE(text.empty());
        EXPECT_EQ(text.find('\n'), std::string::npos);
    }
    EXPECT_EQ(describe({}), "all particles");
    proto::Selection nothing;
    nothing.set_nothing(true);
    EXPECT_EQ(describe(nothing), "no particle");
    EXPECT_EQ(describe(combined({}, Combine::without, nothing)), "(all particles, not no particle)");
    EXPECT_EQ(describe(between(0.5, 2, 3)), "x 0.5 to 2 at step 3");
}

}  // namespace
}  // namespace mote::client
