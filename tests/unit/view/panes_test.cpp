// SPDX-License-Identifier: GPL-3.0-or-later
//
// What panes of a window have together, and where they lie.
#include "client/view/panes/pane.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "client/view/camera_control.h"
#include "protocol/base/json.h"
#include "protocol/scene/annotations.h"
#include "tests/unit/view/panel_hand.h"

namespace mote::client {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// A model of a run of so many steps.
void show(ViewModel& model, const char* dataset, int steps) {
    proto::View view;
    view.add_layers()->set_dataset(dataset);
    view.mutable_layers(0)->mutable_particles();
    ASSERT_TRUE(model.load(view).ok());
    auto manifest = manifestFor(view.layers(0));
    auto& particles = *manifest.mutable_particles();
    const auto step = particles.steps(0);
    particles.clear_steps();
    for (int i = 0; i < steps; ++i) *particles.add_steps() = step;
    model.describe(manifest);
}

proto::Selection ids(std::uint64_t first) {
    proto::Selection selection;
    selection.add_ids(first);
    return selection;
}

std::vector<std::string> namesOf(const ViewModel& model) {
    std::vector<std::string> names;
    const auto view = model.edited();
    for (const auto& each : view.selections()) names.push_back(each.name());
    return names;
}

std::string highlightedOf(const ViewModel& model) {
    return model.edited().layers(0).highlight().selection().named();
}

class LinkedPanes : public testing::Test {
  protected:
    void SetUp() override {
        show(one, "data/beam", 10);
        show(other, "data/beam", 10);
        show(shorter, "data/short", 4);
        follow();
    }
    std::vector<std::size_t> follow() {
        const std::vector<ViewModel*> others{&other, &shorter};
        return linked.follow(one, others, links);
    }

    ViewModel one, other, shorter;
    Links links;
    LinkedViews linked;
};

TEST_F(LinkedPanes, GoToTheSameStepOrToTheirLast) {
    one.setStep(2);
    EXPECT_THAT(follow(), ElementsAre(0, 1));
    EXPECT_EQ(other.step(), 2U);
    EXPECT_EQ(shorter.step(), 2U);
    EXPECT_FALSE(heldStep(shorter, one));
    one.setStep(8);
    follow();
    EXPECT_EQ(other.step(), 8U);
    EXPECT_EQ(shorter.step(), 3U);
    EXPECT_EQ(heldStep(shorter, one), 3U);
    EXPECT_FALSE(heldStep(other, one));
    EXPECT_THAT(follow(), IsEmpty());  // nothing has changed since
    links.steps = false;
    one.setStep(1);
    follow();
    EXPECT_EQ(other.step(), 8U);
}

TEST_F(LinkedPanes, WhatCameInPlaceOfAViewIsNotCarriedOver) {
    auto view = one.edited();
    view.mutable_layers(0)->set_step(5);
    ASSERT_TRUE(one.load(view).ok());
    EXPECT_THAT(follow(), IsEmpty());
    EXPECT_EQ(other.step(), 0U);
    one.setStep(6);
    follow();
    EXPECT_EQ(other.step(), 6U);
}

TEST_F(LinkedPanes, AnotherActivePaneCarriesOverOnlyWhatChangesInIt) {
    links.steps = false;
    one.setStep(5);
    follow();
    links.steps = true;
    const std::vector<ViewModel*> others{&one, &shorter};
    EXPECT_THAT(linked.follow(other, others, links), IsEmpty());
    EXPECT_EQ(one.step(), 5U);
    other.setStep(1);
    linked.follow(other, others, links);
    EXPECT_EQ(one.step(), 1U);
}

TEST_F(LinkedPanes, OfOneDatasetHighlightTheSameSelection) {
    ASSERT_TRUE(other.numbers.take(ids(7), Combine::fresh, "own").ok());
    ASSERT_TRUE(one.numbers.take(ids(1), Combine::fresh, "lasso").ok());
    EXPECT_THAT(follow(), ElementsAre(0));
    EXPECT_THAT(namesOf(other), ElementsAre("own", "lasso"));
    EXPECT_EQ(highlightedOf(other), "lasso");
    EXPECT_THAT(namesOf(shorter), IsEmpty());
    ASSERT_TRUE(one.numbers.rename(0, "core").ok());
    follow();
    EXPECT_THAT(namesOf(other), ElementsAre("own", "core"));
    EXPECT_EQ(highlightedOf(other), "core");
    ASSERT_TRUE(one.numbers.remove(0).ok());
    follow();
    EXPECT_THAT(namesOf(other), ElementsAre("own"));
    EXPECT_EQ(highlightedOf(other), "");
}

TEST_F(LinkedPanes, ASelectionThatSomethingNeedsStays) {
    ASSERT_TRUE(one.numbers.take(ids(1), Combine::fresh, "lasso").ok());
    follow();
    ASSERT_TRUE(other.numbers.take(reference("lasso"), Combine::fresh, "same").ok());
    ASSERT_TRUE(one.numbers.remove(0).ok());
    follow();
    EXPECT_THAT(namesOf(other), ElementsAre("lasso", "same"));
}

TEST_F(LinkedPanes, ALayerThatIsNotChosenHighlightsToo) {
    other.addLayer("data/short", manifestFor(shorter.layer()));
    EXPECT_EQ(other.dataset(), "data/short");
    ASSERT_TRUE(one.numbers.take(ids(1), Combine::fresh, "lasso").ok());
    follow();
    EXPECT_EQ(other.dataset(), "data/short");
    EXPECT_EQ(highlightedOf(other), "lasso");
    EXPECT_FALSE(other.edited().layers(1).has_highlight());
}

TEST_F(LinkedPanes, OfOneRunHighlightWhatColumnsTell) {
    auto plot = manifestFor(one.layer());
    plot.mutable_request()->mutable_particles()->add_inputs("run.h5");
    one.describe(plot);
    plot.mutable_particles()->mutable_columns()->RemoveLast();  // pz
    shorter.describe(plot);
    const std::vector<glm::dvec2> corners{{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}};
    ASSERT_TRUE(one.numbers.take(polygonIn("x", "py", corners), Combine::fresh, "halo").ok());
    follow();
    EXPECT_THAT(namesOf(shorter), ElementsAre("halo"));
    EXPECT_EQ(highlightedOf(shorter), "halo");
    ASSERT_TRUE(one.numbers.take(polygonIn("x", "pz", corners), Combine::fresh, "late").ok());
    proto::Selection lasso;
    lasso.mutable_lasso()->set_aspect(1.0);
    for (int i = 0; i < 3; ++i) {
        auto& point = *lasso.mutable_lasso()->add_points();
        point.add_values()->set_number_value(i % 2);
        point.add_values()->set_number_value(i / 2);
    }
    *lasso.mutable_lasso()->mutable_camera() = toProto(one.camera(1.0));
    ASSERT_TRUE(one.numbers.take(lasso, Combine::fresh, "lasso").ok());
    follow();
    EXPECT_THAT(namesOf(one), ElementsAre("halo", "late", "lasso"));
    EXPECT_THAT(namesOf(other), ElementsAre("halo", "late", "lasso"));
    EXPECT_THAT(namesOf(shorter), ElementsAre("halo"));
    EXPECT_EQ(highlightedOf(shorter), "");
    // One that says its plot holds the same wherever its columns are.
    for (const auto& [last, name] : {std::pair{"y", "round"}, {"pz", "long"}}) {
        auto& said = *lasso.mutable_lasso();
        said.clear_axes();
        said.clear_bounds();
        for (const char* axis : {"x", "px", last}) {
            said.add_axes(axis);
            auto& bounds = *said.add_bounds();
            bounds.add_values()->set_number_value(-1e-3);
            bounds.add_values()->set_number_value(1e-3);
        }
        ASSERT_TRUE(one.numbers.take(lasso, Combine::fresh, name).ok());
        follow();
    }
    EXPECT_THAT(namesOf(other), ElementsAre("halo", "late", "lasso", "round", "long"));
    EXPECT_THAT(namesOf(shorter), ElementsAre("halo", "round"));
}

TEST_F(LinkedPanes, HaveOneCameraOnRequest) {
    one.setCamera(lookFrom(one.camera(1.0), 0, true));
    EXPECT_THAT(follow(), IsEmpty());
    EXPECT_FALSE(other.hasCamera());
    links.cameras = true;
    const std::vector<ViewModel*> others{&other, &shorter};
    EXPECT_THAT(shareAll(one, others, {false, false, true}), ElementsAre(0, 1));
    EXPECT_EQ(other.camera(1.0), one.camera(1.0));
    one.setCamera(lookFrom(one.camera(1.0), 1, true));
    follow();
    EXPECT_EQ(other.camera(1.0), one.camera(1.0));
    EXPECT_EQ(shorter.camera(1.0), one.camera(1.0));
    one.fit();
    follow();
    EXPECT_FALSE(other.hasCamera());
}

TEST(PanesOfAWindow, KeepTheActiveOneAndTheirLinesByPlace) {
    const auto nowhere = [] {
        return std::make_unique<Connection>("/nowhere/connection.json", ConnectionSettings());
    };
    const auto first = nowhere();
    int lines = 0;
    Panes panes(*first, [&] {
        ++lines;
        return nowhere();
    });
    show(panes.active().model, "data/beam", 10);
    panes.active().subject = "data/beam";
    panes.setCount(4);
    ASSERT_EQ(panes.size(), 4U);
    std::vector<PaneState> four;
    for (const auto& pane : panes.looked()) {
        PaneState state;
        state.id = pane.id;
        four.push_back(state);
        EXPECT_EQ(pane.subject, "data/beam");
        EXPECT_EQ(pane.model.edited().SerializeAsString(), panes[0].model.edited().SerializeAsString());
    }
    EXPECT_EQ(&panes.line(0), first.get());
    EXPECT_NE(&panes.line(1), &panes.line(3));
    EXPECT_EQ(lines, 3);
    panes.activate(2);
    panes[2].dirty = false;
    panes.setCount(1);
    ASSERT_EQ(panes.size(), 1U);
    EXPECT_EQ(panes.active().id, four[2].id);
    EXPECT_TRUE(panes.active().dirty);  // it asks over another line
    panes.setIds(four);
    ASSERT_EQ(panes.size(), 4U);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(panes[i].id, four[i].id);
    EXPECT_EQ(panes.activeIndex(), 2U);
    panes.setCount(2);
    EXPECT_EQ(panes.active().id, four[2].id);
    EXPECT_EQ(panes[0].id, four[0].id);
    EXPECT_EQ(panes.find(four[3].id), nullptr);
}

TEST(PanesOfAWindow, PlayWhatHasSteps) {
    Connection first("/nowhere/connection.json", {});
    Panes panes(first, [] { return std::unique_ptr<Connection>(); });
    show(panes.active().model, "data/still", 1);
    panes.setCount(2);
    show(panes[1].model, "data/beam", 10);
    EXPECT_EQ(&panes.timed(), &panes[1]);
    panes.setCount(4);
    show(panes[3].model, "data/beam", 5);
    panes.follow();
    panes.timed().model.setTimedStep(7);
    panes.follow();
    EXPECT_EQ(panes[3].model.step(), 4U);
    EXPECT_EQ(panes[0].model.step(), 0U);
    panes.activate(3);
    EXPECT_EQ(&panes.timed(), &panes[3]);
}

TEST(PaneLetters, AreReadAtAnySize) {
    const auto pixelsOf = [](proto::View view, const PictureArea& area) {
        keepLettersReadable(view, area);
        const double scale = view.has_scale() ? view.scale() : 1.0;
        return checkAnnotations(view.annotations()).ok()
                   ? fontPixels(view.annotations(), area.columns, area.rows, scale)
                   : 0.0;
    };
    proto::View view;
    view.mutable_annotations()->set_axes(true);
    const PictureArea small{469.0F, 343.0F, 1.0F, 0.0F, 0.0F, 469, 343};
    const PictureArea large{1920.0F, 1440.0F, 1.0F, 0.0F, 0.0F, 1920, 1440};
    EXPECT_NEAR(pixelsOf(view, small), 11.0, 1e-9);
    EXPECT_NEAR(pixelsOf(view, large), 24.0, 1e-9);  // 12 at 720 lines
    view.set_scale(0.5);
    EXPECT_NEAR(pixelsOf(view, small), 11.0, 1e-9);
    view.mutable_annotations()->set_font_points(6.0);  // as somebody wants them
    EXPECT_NEAR(pixelsOf(view, small), 4.0, 1e-9);
}

TEST(PaneAreas, FillThePicture) {
    for (const auto& [width, height, scale] :
         {std::array{940.0F, 688.0F, 1.0F}, {1501.0F, 873.0F, 2.0F}, {1.0F, 1.0F, 1.0F}}) {
        PictureArea whole{width, height, scale};
        whole.columns = static_cast<std::uint32_t>(width);
        whole.rows = static_cast<std::uint32_t>(height);
        const auto left = paneArea(whole, 0, 2), right = paneArea(whole, 1, 2);
        EXPECT_EQ(left.height, height);
        EXPECT_GE(right.left, left.width);
        const auto last = paneArea(whole, 3, 4);
        if (width > 10.0F) {
            EXPECT_EQ(right.left + right.width, width);
            EXPECT_EQ(last.left + last.width, width);
            EXPECT_EQ(last.top + last.height, height);
            EXPECT_NEAR(left.width, right.width, 1.0 + scale);
            EXPECT_EQ(left.columns, static_cast<std::uint32_t>(left.width));
        }
        for (std::size_t i = 0; i < 4; ++i) {
            const auto area = paneArea(whole, i, 4);
            EXPECT_GE(area.columns, 1U);
            EXPECT_GE(area.rows, 1U);
        }
    }
}

}  // namespace
}  // namespace mote::client
