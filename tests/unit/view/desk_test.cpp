// SPDX-License-Identifier: GPL-3.0-or-later
//
// All that is worked on is one value: it can be taken back, step by step, and outlives the viewer.
#include "client/view/desk.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <imgui.h>

#include <fstream>

#include "client/view/camera_control.h"
#include "client/view/commands.h"
#include "client/view/over_picture.h"
#include "protocol/scene/json.h"
#include "tests/support/temp_dir.h"
#include "tests/unit/view/panel_hand.h"
#include "tests/views/view_generator.h"

namespace mote::client {
namespace {

using test::Random;
using testing::ElementsAre;

TEST(History, WhatAGestureChangesIsOneStep) {
    History<std::string> history;
    for (const auto& [value, gesture] : {std::pair{"a", 0}, {"b", 1}, {"c", 1}, {"d", 1}, {"e", 2}})
        history.record(value, static_cast<std::uint64_t>(gesture));
    history.record("e", 3);
    history.back();
    EXPECT_EQ(history.present(), "d");
    history.back();
    EXPECT_EQ(history.present(), "a");
    EXPECT_FALSE(history.canGoBack());
    history.forward();
    EXPECT_EQ(history.present(), "d");
    history.record("f", 4);
    EXPECT_FALSE(history.canGoForward());
}

TEST(History, AGestureThatComesBackToWhereItBeganIsNoStep) {
    History<std::string> history;
    history.record("a", 0);
    history.record("b", 1);
    history.record("a", 1);
    EXPECT_FALSE(history.canGoBack());
}

TEST(History, TheOldestStepsGoWhereThereAreTooMany) {
    History<std::string> history;
    for (std::uint64_t i = 0; i < 7000; ++i) history.record(std::to_string(i), i);
    int back = 0;
    for (; history.canGoBack(); history.back()) ++back;
    EXPECT_EQ(back, static_cast<int>(History<std::string>::mostSteps) - 1);
}

/// The viewer without a window: a hand on its panel, on its camera and on its layers.
class DeskAtWork {
  public:
    DeskAtWork(const proto::View& view, std::uint64_t seed) : random_(44, seed) {
        EXPECT_TRUE(model_.load(view).ok());
        desk_.setSubject(view.layers(0).dataset());
        describe();
        tell();
    }

    void act() {
        ++gesture_;
        const int count = model_.layers().size();
        const int any = count > 0 ? static_cast<int>(random_.unit() * count) : 0;
        const double what = random_.unit();
        if (what < 0.15) {
            const auto camera = model_.camera(1.5);
            model_.setCamera(orbit(camera, {random_.unit(), 0.1 * random_.unit()}, camera.target));
        } else if (what < 0.2) {
            model_.fit();
        } else if (what < 0.3) {
            model_.setStep(static_cast<std::uint32_t>(3.0 * random_.unit()));
        } else if (what < 0.4 && count > 0 && count < 6) {
            model_.duplicateLayer(any);
        } else if (what < 0.45 && count > 1) {
            model_.removeLayer(any);
        } else if (what < 0.5 && count > 0) {
            model_.moveLayer(any, 0);
        } else if (what < 0.55 && count > 0) {
            model_.setShown(any, !model_.isShown(any));
        } else if (what < 0.6) {
            model_.choose(any);
        } else if (what < 0.65 && film_.keyframes().size() < 20) {
            static_cast<void>(film_.add(model_.view(640, 480)));
        } else if (what < 0.95 && count > 0) {
            model_.setOpacity(any, random_.unit());
        } else {
            hand_.drag(model_, random_);  // takes longest
        }
        describe();
        tell();
    }

    void restore(const DeskState& state) {
        ++gesture_;
        if (state.film->revision() != film_.revision()) film_ = *state.film;
        ASSERT_TRUE(model_.load(state.view(), state.fromFile).ok());
        describe();
        tell();
    }
    void restoreCamera(const std::string& camera) {
        ++gesture_;
        auto view = model_.edited();
        view.clear_camera();
        if (!camera.empty()) view.mutable_camera()->ParseFromString(camera);
        ASSERT_TRUE(model_.load(view, model_.isLoaded()).ok());
        describe();
        tell();
    }

    /// All there is, to the byte.
    std::string now() const {
        return model_.edited().SerializeAsString() + film_.toScript().SerializeAsString();
    }
    /// The view but for its camera, likewise.
    std::string look() const {
        auto view = model_.edited();
        view.clear_camera();
        return view.SerializeAsString();
    }
    Desk& desk() { return desk_; }

  private:
    void describe() {
        if (model_.isDescribed() || model_.layers().empty()) return;
        hand_.describe(manifestFor(model_.layer()));
        model_.describe(manifestFor(model_.layer()));
    }
    void tell() { desk_.look(model_, film_, gesture_); }

    Random random_;
    ViewModel model_;
    FilmModel film_;
    Desk desk_;
    PanelHand hand_;
    std::uint64_t gesture_ = 0;
};

TEST(Desk, FiveHundredActionsTakenBackLeaveTheFirstViewToTheByte) {
    int steps = 0, views = 0;
    for (std::uint64_t i = 0; views < 2; ++i) {
        const auto view = test::generatedView(45, i);
        if (view.layers().empty()) continue;
        ++views;
        DeskAtWork work(view, i);
        const auto first = work.now();
        for (int action = 0; action < 500; ++action) work.act();
        const auto last = work.now();
        int taken = 0;
        for (; taken <= 500; ++taken) {
            const auto state = work.desk().undo();
            if (!state) break;
            work.restore(*state);
            ASSERT_EQ(work.look(), state->look) << "step " << taken << " back of view " << i;
        }
        ASSERT_LE(taken, 500) << "view " << i;
        steps += taken;
        while (const auto camera = work.desk().cameraBack()) work.restoreCamera(*camera);
        EXPECT_EQ(work.now(), first) << "view " << i;
        while (const auto camera = work.desk().cameraForward()) work.restoreCamera(*camera);
        while (const auto state = work.desk().redo()) work.restore(*state);
        EXPECT_EQ(work.now(), last) << "view " << i;
    }
    EXPECT_GT(steps, 2 * 150);
}

proto::View beam(const char* colors, double eye) {
    proto::View view;
    const auto text = fmt::format(R"({{"camera": {{"eye": [0, 0, {}], "target": [0, 0, 0]}}, "layers":
        [{{"dataset": "data/beam", "particles": {{"volume": {{"colorMap": "{}"}}}}}}]}})",
                                  eye, colors);
    EXPECT_TRUE(parseJson(text, view, "test").ok());
    return view;
}

TEST(Desk, TheCameraHasItsOwnHistory) {
    Desk desk;
    ViewModel model;
    const FilmModel film;
    desk.setSubject("data/beam");
    ASSERT_TRUE(model.load(beam("viridis", 4.0)).ok());
    desk.look(model, film, 0);
    model.setStep(1);
    desk.look(model, film, 1);
    model.setCamera(lookFrom(model.camera(1.0), 0, true));
    desk.look(model, film, 2);
    const auto undone = desk.undo();
    ASSERT_TRUE(undone);
    EXPECT_EQ(undone->view().layers(0).step(), 0U);
    EXPECT_EQ(undone->view().camera().eye(0), 4.0);  // it stays
    const auto camera = desk.cameraBack();
    ASSERT_TRUE(camera);
    EXPECT_FALSE(desk.cameraBack());
}

TEST(Desk, AViewThatCameInPlaceOfAnotherGoesWithItsCamera) {
    Desk desk;
    ViewModel model;
    const FilmModel film;
    desk.setSubject("data/beam");
    ASSERT_TRUE(model.load(beam("viridis", 4.0)).ok());
    desk.look(model, film, 0);
    ASSERT_TRUE(model.load(beam("plasma", 7.0)).ok());
    desk.look(model, film, 1);
    const auto undone = desk.undo();
    ASSERT_TRUE(undone);
    EXPECT_EQ(undone->view().SerializeAsString(), beam("viridis", 4.0).SerializeAsString());
}

TEST(Desk, OnlyWorkIsUnsaved) {
    Desk desk;
    ViewModel model;
    FilmModel film;
    desk.setSubject("data/beam");
    ASSERT_TRUE(model.load(beam("viridis", 4.0)).ok());
    desk.look(model, film, 0);
    model.setStep(1);
    model.setCamera(lookFrom(model.camera(1.0), 0, true));
    desk.look(model, film, 1);
    EXPECT_TRUE(desk.unsaved().empty());
    model.setOpacity(0, 0.5);
    ASSERT_TRUE(film.add(model.view(640, 480)).ok());
    desk.look(model, film, 2);
    EXPECT_THAT(desk.unsaved(), ElementsAre("data/beam", "film"));
    desk.saved();
    desk.filmSaved();
    EXPECT_TRUE(desk.unsaved().empty());
    model.setOpacity(0, 1.0);
    desk.look(model, film, 3);
    EXPECT_THAT(desk.unsaved(), ElementsAre("data/beam"));
}

TEST(Sessions, AreReadAsTheyWereWritten) {
    const test::TempDir folder;
    Desk desk;
    ViewModel model;
    FilmModel film;
    desk.keepIn(folder / "state", "key");
    desk.setSubject("data/beam");
    ASSERT_TRUE(model.load(beam("viridis", 4.0)).ok());
    ASSERT_TRUE(film.add(model.view(640, 480)).ok());
    ASSERT_TRUE(film.add(model.view(640, 480)).ok());
    desk.look(model, film, 0);
    EXPECT_FALSE(desk.isStale());  // nothing was done
    model.setOpacity(0, 0.25);
    desk.look(model, film, 1);
    ASSERT_TRUE(desk.isStale());
    ASSERT_TRUE(desk.writeFile().ok());
    EXPECT_FALSE(desk.isStale());
    const auto session = lastSession(folder / "state", "key");
    ASSERT_TRUE(session);
    EXPECT_EQ(session->subject, "data/beam");
    EXPECT_EQ(session->views.at("data/beam").SerializeAsString(), model.edited().SerializeAsString());
    ASSERT_TRUE(session->film);
    EXPECT_EQ(session->film->SerializeAsString(), film.saved().SerializeAsString());
    EXPECT_FALSE(lastSession(folder / "state", "other"));
    EXPECT_FALSE(lastSession(folder / "none", "key"));
}

TEST(Sessions, ThatAreNoneAreErrors) {
    const test::TempDir folder;
    for (const char* text :
         {"", "mote-view session 2\n", "mote-view session 1\nview data/beam\n{\"layers\": 3}\n",
          "mote-view session 1\nwhat\n", "mote-view session 1\nview data/beam\n"}) {
        std::ofstream(folder / "x.session") << text;
        const auto session = readSession(folder / "x.session");
        EXPECT_FALSE(session.ok()) << text;
    }
    EXPECT_FALSE(readSession(folder / "none.session").ok());
}

TEST(Commands, AreFoundByTheirWords) {
    const std::vector<Command> commands{{"Camera", "Look from +x", "X", {}},
                                        {"Edit", "Undo", "Ctrl+Z", {}},
                                        {"Camera", "Fit", "F", {}},
                                        {"Window", "Panel", "Tab", {}}};
    const auto names = [&](std::string_view typed) {
        std::vector<std::string> found;
        for (const auto* each : findCommands(commands, typed)) found.push_back(each->name);
        return found;
    };
    EXPECT_THAT(names("und"), ElementsAre("Undo"));
    EXPECT_THAT(names("FROM look"), ElementsAre("Look from +x"));
    EXPECT_THAT(names("camera"), ElementsAre("Look from +x", "Fit"));
    EXPECT_THAT(names("f"), ElementsAre("Fit", "Look from +x"));
    EXPECT_THAT(names(""), testing::SizeIs(4));
    EXPECT_THAT(names("nothing"), testing::IsEmpty());
}

/// What a frame tells in which the mouse is there, pressed or not.
std::optional<AxisEnd> triadFrame(const ImVec2& mouse, bool pressed) {
    auto& io = ImGui::GetIO();
    io.MousePos = mouse;
    io.MouseDown[ImGuiMouseButton_Left] = pressed;
    ImGui::NewFrame();
    const auto end = drawTriad(Camera{}, {"x", "px", "y"}, {800.0F, 600.0F, 1.0F});
    ImGui::Render();
    return end;
}

TEST(OverPicture, AClickOnTheTriadTellsWhichEnd) {
    const PanelHand hand;  // frames that nothing shows
    const auto clicked = [](const ImVec2& at) {
        for (const bool pressed : {false, true}) EXPECT_FALSE(triadFrame(at, pressed));
        return triadFrame(at, false);
    };
    const ImVec2 middle{46.0F, 554.0F};  // of a camera that looks along -z
    const auto right = clicked({middle.x + 30.0F, middle.y}), below = clicked({middle.x, middle.y + 30.0F});
    ASSERT_TRUE(right && below);
    EXPECT_TRUE(right->axis == 0 && right->positive);
    EXPECT_TRUE(below->axis == 1 && !below->positive);
    EXPECT_FALSE(clicked({middle.x + 60.0F, middle.y}));
}

}  // namespace
}  // namespace mote::client
