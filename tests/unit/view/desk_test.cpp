// SPDX-License-Identifier: GPL-3.0-or-later
//
// All that is worked on is one value: it can be taken back, step by step, and outlives the viewer.
#include "client/view/desk.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <imgui.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <utility>
#include <vector>

#include "client/view/camera_control.h"
#include "client/view/commands.h"
#include "client/view/over_picture.h"
#include "client/view/panes/pane.h"
#include "protocol/base/json.h"
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

/// The viewer without a window: a hand on its panel, on its cameras, on its layers and on its panes.
class DeskAtWork {
  public:
    DeskAtWork(const proto::View& view, std::uint64_t seed) : random_(44, seed) {
        panes_.push_back(std::make_unique<Pane>(0));
        pane().subject = view.layers(0).dataset();
        EXPECT_TRUE(model().load(view).ok());
        tell();
    }

    void act() {
        ++gesture_;
        const int count = model().layers().size();
        const int any = count > 0 ? static_cast<int>(random_.unit() * count) : 0;
        const double what = random_.unit();
        if (what < 0.15) {
            const auto camera = model().camera(1.5);
            model().setCamera(orbit(camera, {random_.unit(), 0.1 * random_.unit()}, camera.target));
        } else if (what < 0.2) {
            model().fit();
        } else if (what < 0.3) {
            model().setStep(static_cast<std::uint32_t>(3.0 * random_.unit()));
        } else if (what < 0.4 && count > 0 && count < 6) {
            model().duplicateLayer(any);
        } else if (what < 0.45 && count > 1) {
            model().removeLayer(any);
        } else if (what < 0.5 && count > 0) {
            model().moveLayer(any, 0);
        } else if (what < 0.55 && count > 0) {
            model().setShown(any, !model().isShown(any));
        } else if (what < 0.6) {
            model().choose(any);
        } else if (what < 0.65 && film_.keyframes().size() < 20) {
            static_cast<void>(film_.add(model().view(640, 480)));
        } else if (what < 0.75) {
            changePanes();
        } else if (what < 0.95 && count > 0) {
            model().setOpacity(any, random_.unit());
            model().setDepthContrast(random_.unit());
        } else {
            hand_.drag(model(), random_);  // takes longest
        }
        tell();
    }

    void restore(const DeskState& state) {
        ++gesture_;
        if (state.film->revision() != film_.revision()) film_ = *state.film;
        links_ = state.links;
        auto before = std::exchange(panes_, {});
        for (const auto& was : state.panes) {
            const auto known =
                std::ranges::find_if(before, [&](const auto& each) { return each && each->id == was.id; });
            panes_.push_back(known != before.end() ? std::move(*known) : std::make_unique<Pane>(was.id));
            panes_.back()->subject = was.subject;
            ASSERT_TRUE(panes_.back()->model.load(was.view(), was.fromFile).ok());
        }
        active_ = std::min(active_, panes_.size() - 1);
        tell();
    }
    void restoreCameras(const PaneCameras& cameras) {
        ++gesture_;
        for (const auto& each : panes_) {
            const auto camera = cameras.all.find(each->id);
            if (camera == cameras.all.end()) continue;
            auto view = each->model.edited();
            view.clear_camera();
            if (!camera->second.empty()) view.mutable_camera()->ParseFromString(camera->second);
            ASSERT_TRUE(each->model.load(view, each->model.isLoaded()).ok());
        }
        tell();
    }

    /// All there is, to the byte.
    std::string now() const {
        std::string bytes = film_.toScript().SerializeAsString();
        for (const auto& each : panes_) bytes += each->subject + each->model.edited().SerializeAsString();
        return bytes + fmt::format("{}{}{}", links_.steps, links_.selections, links_.cameras);
    }
    /// The views but for their cameras, likewise.
    std::vector<std::string> looks() const {
        std::vector<std::string> looks;
        for (const auto& each : panes_) {
            auto view = each->model.edited();
            view.clear_camera();
            looks.push_back(view.SerializeAsString());
        }
        return looks;
    }
    Desk& desk() { return desk_; }
    std::size_t panes() const { return panes_.size(); }

  private:
    Pane& pane() { return *panes_[active_]; }
    ViewModel& model() { return pane().model; }

    void changePanes() {
        const double what = random_.unit();
        if (what < 0.3 && panes_.size() < mostPanes) {
            panes_.push_back(std::make_unique<Pane>(++ids_));
            panes_.back()->copy(pane());
        } else if (what < 0.5 && panes_.size() > 1) {
            panes_.erase(panes_.begin() + static_cast<std::ptrdiff_t>(random_.unit() * panes_.size()));
            active_ = 0;
        } else if (what < 0.8) {
            active_ = static_cast<std::size_t>(random_.unit() * panes_.size());
        } else {
            auto& link = what < 0.9 ? links_.cameras : links_.steps;
            link = !link;
        }
    }
    void follow() {
        std::vector<ViewModel*> others;
        for (const auto& each : panes_) {
            if (each.get() != &pane()) others.push_back(&each->model);
        }
        linked_.follow(model(), others, links_);
    }
    void describe() {
        for (const auto& each : panes_) {
            if (each->model.isDescribed() || each->model.layers().empty()) continue;
            hand_.describe(manifestFor(each->model.layer()));
            each->model.describe(manifestFor(each->model.layer()));
        }
    }
    void tell() {
        describe();
        follow();
        describe();
        std::vector<DeskPane> looked;
        for (const auto& each : panes_) looked.push_back({each->id, each->subject, each->model});
        desk_.look(looked, active_, links_, film_, gesture_);
    }

    Random random_;
    std::vector<std::unique_ptr<Pane>> panes_;
    std::size_t active_ = 0;
    std::uint64_t ids_ = 0;
    Links links_;
    LinkedViews linked_;
    FilmModel film_;
    Desk desk_;
    PanelHand hand_;
    std::uint64_t gesture_ = 0;
};

std::vector<std::string> looksOf(const DeskState& state) {
    std::vector<std::string> looks;
    for (const auto& pane : state.panes) looks.push_back(pane.look);
    return looks;
}

TEST(Desk, FiveHundredActionsTakenBackLeaveTheFirstViewToTheByte) {
    int steps = 0, views = 0;
    std::size_t mostAtOnce = 0;
    for (std::uint64_t i = 0; views < 2; ++i) {
        const auto view = test::generatedView(45, i);
        if (view.layers().empty()) continue;
        ++views;
        DeskAtWork work(view, i);
        const auto first = work.now();
        for (int action = 0; action < 500; ++action) {
            work.act();
            mostAtOnce = std::max(mostAtOnce, work.panes());
        }
        const auto last = work.now();
        int taken = 0;
        for (; taken <= 500; ++taken) {
            const auto state = work.desk().undo();
            if (!state) break;
            work.restore(*state);
            ASSERT_EQ(work.looks(), looksOf(*state)) << "step " << taken << " back of view " << i;
        }
        ASSERT_LE(taken, 500) << "view " << i;
        steps += taken;
        while (const auto cameras = work.desk().cameraBack()) work.restoreCameras(*cameras);
        EXPECT_EQ(work.now(), first) << "view " << i;
        while (const auto state = work.desk().redo()) work.restore(*state);
        while (const auto cameras = work.desk().cameraForward()) work.restoreCameras(*cameras);
        EXPECT_EQ(work.now(), last) << "view " << i;
    }
    EXPECT_GT(steps, 2 * 150);
    EXPECT_EQ(mostAtOnce, mostPanes);
}

proto::View beam(const char* colors, double eye) {
    proto::View view;
    const auto text = fmt::format(R"({{"camera": {{"eye": [0, 0, {}], "target": [0, 0, 0]}}, "layers":
        [{{"dataset": "data/beam", "particles": {{"volume": {{"colorMap": "{}"}}}}}}]}})",
                                  eye, colors);
    EXPECT_TRUE(parseJson(text, view, "test").ok());
    return view;
}

/// At a window of one pane.
void look(Desk& desk, const ViewModel& model, const FilmModel& film, std::uint64_t gesture) {
    const std::vector<DeskPane> panes{{1, "data/beam", model}};
    desk.look(panes, 0, {}, film, gesture);
}

TEST(Desk, TheCameraHasItsOwnHistory) {
    Desk desk;
    ViewModel model;
    const FilmModel film;
    ASSERT_TRUE(model.load(beam("viridis", 4.0)).ok());
    look(desk, model, film, 0);
    model.setStep(1);
    look(desk, model, film, 1);
    model.setCamera(lookFrom(model.camera(1.0), 0, true));
    look(desk, model, film, 2);
    const auto undone = desk.undo();
    ASSERT_TRUE(undone);
    EXPECT_EQ(undone->panes[0].view().layers(0).step(), 0U);
    EXPECT_EQ(undone->panes[0].view().camera().eye(0), 4.0);  // it stays
    const auto camera = desk.cameraBack();
    ASSERT_TRUE(camera);
    EXPECT_FALSE(desk.cameraBack());
}

TEST(Desk, AViewThatCameInPlaceOfAnotherGoesWithItsCamera) {
    Desk desk;
    ViewModel model;
    const FilmModel film;
    ASSERT_TRUE(model.load(beam("viridis", 4.0)).ok());
    look(desk, model, film, 0);
    ASSERT_TRUE(model.load(beam("plasma", 7.0)).ok());
    look(desk, model, film, 1);
    const auto undone = desk.undo();
    ASSERT_TRUE(undone);
    EXPECT_EQ(undone->panes[0].view().SerializeAsString(), beam("viridis", 4.0).SerializeAsString());
}

TEST(Desk, OnlyWorkIsUnsaved) {
    Desk desk;
    ViewModel model;
    FilmModel film;
    ASSERT_TRUE(model.load(beam("viridis", 4.0)).ok());
    look(desk, model, film, 0);
    model.setStep(1);
    model.setCamera(lookFrom(model.camera(1.0), 0, true));
    look(desk, model, film, 1);
    EXPECT_TRUE(desk.unsaved().empty());
    model.setOpacity(0, 0.5);
    ASSERT_TRUE(film.add(model.view(640, 480)).ok());
    look(desk, model, film, 2);
    EXPECT_THAT(desk.unsaved(), ElementsAre("data/beam", "film"));
    desk.saved();
    desk.filmSaved();
    EXPECT_TRUE(desk.unsaved().empty());
    model.setOpacity(0, 1.0);
    look(desk, model, film, 3);
    EXPECT_THAT(desk.unsaved(), ElementsAre("data/beam"));
}

TEST(Sessions, AreReadAsTheyWereWritten) {
    const test::TempDir folder;
    Desk desk;
    ViewModel model;
    FilmModel film;
    desk.keepIn(folder / "state", "key");
    ASSERT_TRUE(model.load(beam("viridis", 4.0)).ok());
    ASSERT_TRUE(film.add(model.view(640, 480)).ok());
    ASSERT_TRUE(film.add(model.view(640, 480)).ok());
    look(desk, model, film, 0);
    EXPECT_FALSE(desk.isStale());  // nothing was done
    model.setOpacity(0, 0.25);
    look(desk, model, film, 1);
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

TEST(Desk, PanesComeAndGoAsOneStepWithTheirCameras) {
    Desk desk;
    ViewModel one, other;
    const FilmModel film;
    ASSERT_TRUE(one.load(beam("viridis", 4.0)).ok());
    look(desk, one, film, 0);
    other.copy(one);
    EXPECT_EQ(other.edited().SerializeAsString(), one.edited().SerializeAsString());
    const std::vector<DeskPane> two{{1, "data/beam", one}, {2, "data/beam", other}};
    desk.look(two, 0, {}, film, 1);
    other.setCamera(lookFrom(other.camera(1.0), 0, true));
    const auto turned = other.edited().camera().SerializeAsString();
    desk.look(two, 1, {}, film, 2);
    const auto undone = desk.undo();
    ASSERT_TRUE(undone);
    EXPECT_EQ(undone->panes.size(), 1U);
    look(desk, one, film, 3);
    EXPECT_FALSE(desk.cameraBack());  // the other pane's turn is not to be seen
    const auto again = desk.redo();
    ASSERT_TRUE(again);
    ASSERT_EQ(again->panes.size(), 2U);
    EXPECT_EQ(again->panes[1].camera, turned);
}

TEST(Desk, EachPaneHasWorkOfItsOwn) {
    Desk desk;
    ViewModel one, other;
    const FilmModel film;
    ASSERT_TRUE(one.load(beam("viridis", 4.0)).ok());
    look(desk, one, film, 0);
    other.copy(one);
    const std::vector<DeskPane> two{{1, "data/beam", one}, {2, "data/beam", other}};
    one.setOpacity(0, 0.5);
    desk.look(two, 0, {}, film, 1);
    desk.look(two, 1, {}, film, 2);
    EXPECT_THAT(desk.unsaved(), ElementsAre("data/beam"));
    desk.saved();  // the other one's
    EXPECT_THAT(desk.unsaved(), ElementsAre("data/beam"));
    desk.look(two, 0, {}, film, 3);
    desk.saved();
    EXPECT_TRUE(desk.unsaved().empty());
}

TEST(Sessions, KeepPanesAndLinks) {
    const test::TempDir folder;
    Desk desk;
    ViewModel one, other;
    const FilmModel film;
    desk.keepIn(folder / "state", "key");
    ASSERT_TRUE(one.load(beam("viridis", 4.0)).ok());
    ASSERT_TRUE(other.load(beam("plasma", 7.0)).ok());
    look(desk, one, film, 0);
    const std::vector<DeskPane> two{{1, "data/beam", one}, {2, "data/ct", other}};
    desk.look(two, 1, {false, true, true}, film, 1);
    ASSERT_TRUE(desk.isStale());
    ASSERT_TRUE(desk.writeFile().ok());
    const auto session = lastSession(folder / "state", "key");
    ASSERT_TRUE(session);
    EXPECT_EQ(session->subject, "data/ct");
    EXPECT_EQ(session->active, 1U);
    EXPECT_EQ(session->links, (Links{false, true, true}));
    ASSERT_EQ(session->panes.size(), 2U);
    EXPECT_EQ(session->panes[0].subject, "data/beam");
    EXPECT_EQ(session->panes[0].view.SerializeAsString(), one.edited().SerializeAsString());
    EXPECT_EQ(session->panes[1].view.SerializeAsString(), other.edited().SerializeAsString());
    Desk next;
    next.adopt(*session);
    next.look(two, 1, session->links, film, 0);
    EXPECT_TRUE(next.unsaved().empty());
}

TEST(Sessions, ThatAreNoneAreErrors) {
    const test::TempDir folder;
    for (const char* text :
         {"", "mote-view session 2\n", "mote-view session 1\nview data/beam\n{\"layers\": 3}\n",
          "mote-view session 1\nwhat\n", "mote-view session 1\nview data/beam\n",
          "mote-view session 1\npanes 1\nsteps\npane data/beam\n{}\n",
          "mote-view session 1\npanes 0\nthoughts\npane data/beam\n{}\npane data/beam\n{}\n",
          "mote-view session 1\npanes 0\n\npane a\n{}\npane a\n{}\npane a\n{}\npane a\n{}\npane a\n{}\n"}) {
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
