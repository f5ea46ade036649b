// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the user does in the viewer's window, what the viewer can be told to do, what was before, and what it
// says on the picture.
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <utility>

#include "client/shared/jobs.h"
#include "client/shared/script.h"
#include "client/view/camera_control.h"
#include "client/view/viewer.h"
#include "protocol/base/complain.h"
#include "protocol/base/json.h"
#include "protocol/scene/view.h"

namespace mote::client {

Status Viewer::openView(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(auto saved, readSavedView(path));
    const auto loaded = model().load(saved.view);
    if (!loaded.ok()) {
        const auto& error = loaded.error();
        return Error{error.code, fmt::format("{}: {}", path.string(), error.where), error.message};
    }
    note_ = std::move(saved.note);
    pane().subject = saved.view.layers().empty() ? std::string() : saved.view.layers(0).dataset();
    pane().dirty = true;
    return success();
}

Status Viewer::saveView(const std::filesystem::path& path, SameName sameName) {
    const auto area = activeArea();
    const auto view = model().saved(area.columns, area.rows);
    MOTE_RETURN_IF_ERROR(saveJson(path, view, sameName));
    lookAtDesk();
    desk_.saved();
    say(view.width() == 0 || view.height() == 0
            ? fmt::format("saved {}, without a size as it was loaded", path.string())
            : fmt::format("saved {}, {} x {} pixels", path.string(), view.width(), view.height()));
    return success();
}

void Viewer::takePaths(const PanelActions& actions) {
    const auto answer = [](PathPrompt& prompt, const Status& status) {
        status.ok() ? prompt.close() : prompt.fail(status.error().toString());
    };
    if (const auto& path = actions.saveViewTo) {
        const bool agreed = files_.saving.agreed(*path);
        answer(files_.saving, saveView(*path, agreed ? SameName::isReplaced : SameName::stays));
    }
    if (const auto& path = actions.saveStyleTo) {
        const bool agreed = files_.savingStyle.agreed(*path);
        answer(files_.savingStyle,
               saveJson(*path, model().style(), agreed ? SameName::isReplaced : SameName::stays));
    }
    if (actions.openStyleFrom) answer(files_.openingStyle, openStyle(*actions.openStyleFrom));
    if (actions.savePictureTo) savePicture(*actions.savePictureTo);
    if (!actions.openViewFrom) return;
    film_.stop();
    const auto opened = openView(*actions.openViewFrom);
    answer(files_.opening, opened);
    if (!opened.ok()) return;
    lookAtDesk();
    desk_.saved();
    say(std::exchange(note_, {}));
}

Status Viewer::openStyle(const std::filesystem::path& path) {
    proto::Layer style;
    MOTE_RETURN_IF_ERROR(readJsonFile(path, style));
    pane().dirty = true;
    return model().setStyle(style);
}

void Viewer::savePicture(const std::filesystem::path& path) {
    using Of = ViewFiles::PictureOf;
    const auto [width, height] = files_.pictureSize;
    const auto limit = static_cast<int>(View::maxSide);
    if (files_.pictureOf == Of::window) {
        windowTo_ = path;
    } else if (width < 1 || height < 1 || width > limit || height > limit) {
        return files_.savingPicture.fail(fmt::format("a picture has 1 to {} pixels a side", limit));
    } else if (const auto asked = askPicture({path, files_.pictureOf == Of::view}, width, height);
               !asked.ok()) {
        return files_.savingPicture.fail(asked.error().toString());
    }
    files_.savingPicture.close();
}

/// As it is shown, with its points and letters in proportion.
Status Viewer::askPicture(const PictureGoal& goal, int width, int height) {
    const auto area = activeArea();
    auto view = model().view(area.columns, area.rows);
    const double factor = static_cast<double>(height) / area.rows;
    if (factor != 1.0) view.set_scale((view.has_scale() ? view.scale() : 1.0) * factor);
    view.set_width(static_cast<std::uint32_t>(width));
    view.set_height(static_cast<std::uint32_t>(height));
    return pictures_.want(std::move(view), goal);
}

void Viewer::copyPicture(bool background) {
    const auto area = activeArea();
    const auto asked =
        askPicture({std::nullopt, background}, static_cast<int>(area.columns), static_cast<int>(area.rows));
    if (!asked.ok()) say(asked.error().toString());
}

void Viewer::keepWindow() {
    if (!windowTo_ || settling_ > 0 || ImGui::IsAnyMouseDown()) return;
    const auto path = *std::exchange(windowTo_, {});
    const int width = window_->framebufferWidth(), height = window_->framebufferHeight();
    const auto kept = writeScreenshot(path, window_->readPixels(), width, height);
    say(kept.ok() ? fmt::format("saved {}, {} x {} pixels, the whole window", path.string(), width, height)
                  : kept.error().toString());
}

/// The view lies beside the sessions, so that the command is all there is to it.
void Viewer::copyCommand() {
    const auto area = activeArea();
    const auto path = freshPath(sessionFolder() / "views" / "view.json");
    std::error_code code;
    std::filesystem::create_directories(path.parent_path(), code);
    auto view = model().view(area.columns, area.rows);
    leaveOutMissing(view);
    if (panes_.size() > 1 && view.has_annotations()) keepLettersReadable(view, area);
    const auto kept = saveJson(path, view, SameName::stays);
    if (!kept.ok()) return say(kept.error().toString());
    ImGui::SetClipboardText(commandOf(path, options_.connection, options_.spawn).c_str());
    say("The command that makes this picture is in the clipboard.");
}

float Viewer::timeHeight(float scale) const {
    return panelShown_ && timed().model.timedSteps() > 1 ? TimeBar::height(scale) : 0.0F;
}

float Viewer::filmHeight(float scale) const {
    return panelShown_ && filmShown_ ? FilmPanel::height(scale) : 0.0F;
}

PictureArea Viewer::pictureArea() const {
    const ImVec2 density = ImGui::GetIO().DisplayFramebufferScale;
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    return areaWithin({display.x, display.y}, {density.x, density.y}, window_->contentScale());
}

/// `size` of the window in screen coordinates, each of which is `density` pixels.
PictureArea Viewer::areaWithin(glm::vec2 size, glm::vec2 density, float scale) const {
    const float panel = panelShown_ ? panelWidth_ * scale : 0.0F;
    const float width = std::max(size.x - panel, 1.0F),
                height = std::max(size.y - filmHeight(scale) - timeHeight(scale), 1.0F);
    return {width,
            height,
            scale,
            0.0F,
            0.0F,
            static_cast<std::uint32_t>(std::max(width * density.x, 1.0F)),
            static_cast<std::uint32_t>(std::max(height * density.y, 1.0F))};
}

PictureArea Viewer::activeArea() const {
    return paneArea(pictureArea(), panes_.activeIndex(), panes_.size());
}

/// A press or a turn of the wheel on another pane is that one's, which is the active one from then on.
void Viewer::takePress(const PictureArea& whole) {
    const auto& io = ImGui::GetIO();
    bool begins = io.MouseWheel != 0.0F;
    for (int button = 0; button < 3; ++button) {
        if (ImGui::IsMouseDown(button) && !ImGui::IsMouseClicked(button)) return;  // of a gesture under way
        begins |= ImGui::IsMouseClicked(button);
    }
    if (!begins || io.WantCaptureMouse) return;
    for (std::size_t i = 0; i < panes_.size(); ++i) {
        if (paneArea(whole, i, panes_.size()).holds(io.MousePos.x, io.MousePos.y)) activate(i);
    }
}

/// A press, a key and a turn of the wheel begin something of their own; what follows belongs to it.
void Viewer::countGestures() {
    constexpr double wheelPause = 0.5;  // seconds; sooner it turns on
    const auto& io = ImGui::GetIO();
    bool begun = false;
    for (int button = 0; button < 3; ++button) begun |= ImGui::IsMouseClicked(button);
    if (io.MouseWheel != 0.0F)
        begun |= ImGui::GetTime() > std::exchange(lastWheel_, ImGui::GetTime()) + wheelPause;
    if (flying_ && !io.WantCaptureMouse) begun = false;  // a flight is one
    gesture_ += begun ? 1 : 0;
}

/// On what is seen there: in the middle of it, as far as the boxes of datasets tell; else beside the target.
glm::dvec3 Viewer::placeUnderPointer(const PictureArea& area) const {
    const auto& mouse = ImGui::GetIO().MousePos;
    const auto at = area.partAt(mouse.x, mouse.y);
    const auto& picture = pane().picture;
    const Camera camera = model().camera(area.aspect());
    const auto column = static_cast<std::size_t>(std::clamp(at.x, 0.0, 1.0 - 1e-9) * picture.width);
    const auto row = static_cast<std::size_t>(std::clamp(at.y, 0.0, 1.0 - 1e-9) * picture.height);
    const std::size_t pixel = 4 * (row * picture.width + column);
    if (pixel + 3 >= picture.bytes.size()) return camera.target;
    bool something = false;
    for (std::size_t i = 0; i < 3; ++i)
        something |= std::abs(picture.bytes[pixel + i] - 255.0F * model().background[i]) > 8.0F;
    const auto box = model().worldBounds();
    const auto within = something && box ? placeWithin(camera, area.aspect(), at, *box) : std::nullopt;
    return within.value_or(placeAt(camera, area.aspect(), at));
}

void Viewer::takeInput(const PictureArea& area) {
    const ImGuiIO& io = ImGui::GetIO();
    const bool held = ImGui::IsMouseDown(ImGuiMouseButton_Left) ||
                      ImGui::IsMouseDown(ImGuiMouseButton_Right) ||
                      ImGui::IsMouseDown(ImGuiMouseButton_Middle);
    moving_ = held && !io.WantCaptureMouse;
    if (lens_.takeMouse(area)) {
        moving_ = false;
        return;
    }
    PanelActions gesture;
    if (numbers_.takeMouse(model(), shownManifest(), area, gesture)) {
        pane().dirty |= gesture.viewChanged;
        moving_ = false;
        return;
    }
    bool pulled = false;
    const bool brushed = handles_.brush.takeMouse(model(), area, pulled);
    askForBrush();
    pane().dirty |= pulled;
    if (pulled || brushed) film_.stop();
    if (brushed) return;
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    draw.PushClipRect({area.left, area.top}, {area.left + area.width, area.top + area.height});
    const bool holding = handles_.draw(model(), area, pulled);
    draw.PopClipRect();
    pane().dirty |= pulled;
    if (holding) film_.stop();
    if (io.WantCaptureMouse || holding) return;
    if (moving_ || io.MouseWheel != 0.0F) film_.stop();
    flying_ ? lookAround(area, held) : turn(area, held);
}

/// What drags and the wheel do to the camera.
void Viewer::turn(const PictureArea& area, bool held) {
    const ImGuiIO& io = ImGui::GetIO();
    Camera camera = model().camera(area.aspect());
    const auto at = area.partAt(io.MousePos.x, io.MousePos.y);
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
        pivot_ = placeUnderPointer(area);
        // Beside all that is shown, about the middle.
        if (pivot_ == placeAt(camera, area.aspect(), at)) pivot_ = camera.target;
    }
    const glm::dvec2 drag(io.MouseDelta.x / area.height, io.MouseDelta.y / area.height);
    const bool dragged = drag != glm::dvec2(0.0) && held;
    if (dragged && ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
        const glm::dvec2 arm((at.x - 0.5) * area.width, (0.5 - at.y) * area.height);
        const glm::dvec2 before = arm - glm::dvec2(io.MouseDelta.x, -io.MouseDelta.y);
        camera = io.KeyShift ? roll(camera, std::atan2(arm.y, arm.x) - std::atan2(before.y, before.x))
                             : orbit(camera, drag, pivot_);
    } else if (dragged) {
        camera = pan(camera, drag);
    }
    if (io.MouseWheel != 0.0F)
        camera =
            io.KeyCtrl ? zoom(camera, io.MouseWheel) : dolly(camera, io.MouseWheel, placeUnderPointer(area));
    if (dragged || io.MouseWheel != 0.0F) setCamera(camera);
}

void Viewer::takeKeys() {
    for (const auto& key : window_->takeKeys()) {
        const bool typing =
            ImGui::GetIO().WantTextInput || palette_.isOpen() ||
            ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel);
        if (typing || isSteeringKey(key) || takeBrushKey(key)) continue;
        for (const auto& command : commands_) {
            if (command.keys != key.chord || (key.repeated && !command.repeats)) continue;
            gesture_ += key.repeated ? 0 : 1;
            command.run();
            lookAtDesk();  // each of several keys in a frame is a step of its own
            gesture_ += flying_ ? 1 : 0;
            if (key.chord.starts_with("Ctrl+")) window_->holdKeys(3);  // it may ask for letters
        }
    }
}

void Viewer::apply(const PanelActions& actions) {
    if (actions.viewChanged) film_.stop();
    pane().dirty |= actions.viewChanged;
    moving_ |= actions.editing;
    say(actions.refused);
    if (actions.command != nullptr) run(actions.command);
    if (actions.plot) plot(*actions.plot);
    if (actions.camera) takeCameraWish(*actions.camera);
    for (const auto& job : server_.jobs) {
        if (job.id() != actions.saveFilm) continue;
        filmShown_ = true;  // it asks where to
        film_.askWhereToSave(job);
    }
    if (actions.cancelJob) {
        connection_.cancelJob(*actions.cancelJob, [this](const Result<proto::JobStatus>& reply) {
            if (!reply.ok()) say(reply.error().toString());
        });
    }
    if (actions.retryJob) {
        connection_.retryJob(*actions.retryJob, [this](const Result<proto::JobStatus>& reply) {
            reply.ok() ? replaceJob(*reply) : say(reply.error().toString());
        });
    }
    if (actions.openDataset) openDataset(*actions.openDataset);
    if (actions.moreJobs) addOlderJobs();
}

/// The next page on which there is anything new: those of the beginning were listed by their states.
void Viewer::addOlderJobs() {
    connection_.listJobs(jobsPaged_, [this](Result<proto::Jobs> reply) {
        if (!reply.ok()) return say(reply.error().toString());
        const auto before = server_.jobs.size();
        for (const auto& job : reply->jobs()) {
            const auto isJob = [&](const auto& known) { return known.id() == job.id(); };
            if (std::ranges::none_of(server_.jobs, isJob)) server_.jobs.push_back(job);
        }
        jobsPaged_ += static_cast<std::uint64_t>(reply->jobs_size());
        server_.allJobs = reply->jobs().empty() ? server_.jobs.size() : reply->total();
        if (server_.jobs.size() == before && !reply->jobs().empty()) addOlderJobs();
    });
}

/// Panes that go along are seen too before all go on.
void Viewer::play() {
    auto& model = timed().model;
    if (!timed().shown) return;
    bool seen = timed().isSeen();
    for (std::size_t i = 0; i < panes_.size() && panes_.links().steps; ++i) {
        const bool comes = panes_.line(i).state() == Connection::State::connected;
        seen &= !comes || panes_[i].isSeen() || !panes_[i].failure.empty();
    }
    const auto step = playback_.next(ImGui::GetTime(), model.timedLayer().step(), model.timedSteps(), seen);
    if (!step) return;
    model.setTimedStep(*step);
    timed().dirty = true;
}

void Viewer::drawTime(const PictureArea& whole) {
    if (timeHeight(whole.scale) <= 0.0F) return;
    PanelActions actions;
    const auto* described = film_.description(timed().model.timedLayer().dataset());
    const auto scales = described != nullptr ? timeScales(described->manifest()) : std::vector<TimeScale>();
    const auto before = timed().model.timedLayer().step();
    const auto scale = timeBar_.scale;
    timeBar_.loaded.look(ImGui::GetTime(), timed().model.timedLayer().dataset(), timed().frame.get(),
                         connection_);
    timeBar_.draw(timed().model, playback_, scales, {0.0F, whole.height, whole.width, whole.scale}, actions);
    timed().dirty |= timed().model.timedLayer().step() != before;
    if (timeBar_.scale != scale) keepWish(timeScaleWish, timeBar_.scale);
    apply(actions);
}

const proto::Manifest* Viewer::shownManifest() const {
    return pane().shown ? &pane().shown->manifest() : nullptr;
}

/// What the histogram's window changes of the view, and the numbers that are asked for.
void Viewer::editNumbers(const PictureArea& area) {
    PanelActions actions;
    numbers_.drawOver(model(), shownManifest(), area, actions, moving_);
    pane().dirty |= actions.viewChanged;
}

/// What a film's bar and its preview change of the view.
void Viewer::editFilm(const PictureArea& whole) {
    const double now = ImGui::GetTime();
    if (const auto view = film_.play(now)) showView(pane(), *view);
    if (panelShown_ && filmShown_) {
        const auto area = activeArea();
        const auto present = model().view(area.columns, area.rows);
        const FilmSurroundings around{0.0F,
                                      whole.height + timeHeight(whole.scale),
                                      whole.width,
                                      whole.scale,
                                      now,
                                      present,
                                      pane().picture,
                                      server_};
        if (const auto view = film_.draw(around)) showView(pane(), *view);
    }
    moving_ |= film_.moving();
    if (still()) film_.askThumbnails();
}

void Viewer::makeCommands() {
    const auto add = [this](const char* group, std::string name, const char* keys, std::function<void()> run,
                            bool repeats = false) {
        commands_.push_back({group, std::move(name), keys, std::move(run), repeats});
    };
    add(
        "Edit", "Undo", "Ctrl+Z", [this] { restore(desk_.undo(), "before this"); }, true);
    add(
        "Edit", "Redo", "Ctrl+Shift+Z", [this] { restore(desk_.redo(), "after this"); }, true);
    add("File", "Open view...", "Ctrl+O", [this] { files_.opening.open(); });
    add("File", "Save view...", "Ctrl+S",
        [this] { files_.saving.open(files_.saving.hasPath() ? "" : freshPath("view.json")); });
    add("File", "Save picture...", "Ctrl+P", [this] {
        const auto area = activeArea();
        files_.pictureSize = {static_cast<int>(area.columns), static_cast<int>(area.rows)};
        files_.savingPicture.open(freshPath("picture.png"));
    });
    add("File", "Copy picture", "Ctrl+C", [this] { copyPicture(true); });
    add("File", "Copy picture without its background", "", [this] { copyPicture(false); });
    add("File", "Copy the command that makes this picture", "Ctrl+Shift+C", [this] { copyCommand(); });
    add("Style", "Copy style", "", [this] { ImGui::SetClipboardText(toJson(model().style()).c_str()); });
    add("Style", "Paste style", "", [this] {
        const char* clipboard = ImGui::GetClipboardText();
        proto::Layer style;
        auto pasted = parseJson(clipboard != nullptr ? clipboard : "", style, "the clipboard");
        if (pasted.ok()) pasted = model().setStyle(style);
        if (!pasted.ok()) return say(pasted.error().toString());
        pane().dirty = true;
    });
    add("Style", "Open style...", "", [this] { files_.openingStyle.open(); });
    add("Style", "Save style...", "", [this] { files_.savingStyle.open(); });
    add("File", "Last session", "", [this] {
        if (offered_) return takeUpSession(*offered_);
        say("No earlier session of this server is known.");
    });
    add("File", "Open dataset...", "D", [this] { browser_.open(DatasetBrowser::Use::open); });
    add("File", "Prepare a file...", "Shift+D", [this] { browser_.openFiles(); });
    add("Layer", "Add dataset...", "", [this] { browser_.open(DatasetBrowser::Use::add); });
    add("Layer", "Replace dataset...", "", [this] { browser_.open(DatasetBrowser::Use::replace); });
    add("Layer", "Cut away by hand", "C", [this] { handles_.cuts = !handles_.cuts; });
    add("Layer", "Paint by hand", "B", [this] { toggleBrush(); });
    add("Layer", "Place by hand", "G", [this] { handles_.places = !handles_.places; });
    add("Camera", "Fit", "F", [this] { fitView(); });
    add("Camera", "Fit to the selection", "", [this] { fitSelection(); });
    add("Camera", "Keep this camera", "", [this] { takeCameraWish({CameraWish::What::keep}); });
    add("Camera", "Fly", "Shift+F", [this] { setFlying(!flying_); });
    add("Camera", "Gamepads and 3D mice on or off", "", [this] { useDevices(isMarked(noDevices)); });
    add(
        "Camera", "Camera before", "[", [this] { showCameras(desk_.cameraBack()); }, true);
    add(
        "Camera", "Camera after", "]", [this] { showCameras(desk_.cameraForward()); }, true);
    add("Camera", "Other projection", "O", [this] { setCamera(toggleProjection(model().camera(1.0))); });
    add("Camera", "Roll by 90 degrees", "R",
        [this] { setCamera(roll(model().camera(1.0), glm::half_pi<double>())); });
    for (int axis = 0; axis < 3; ++axis) {
        for (const bool positive : {true, false}) {
            static constexpr std::array<std::array<const char*, 2>, 3> keys{
                {{"X", "Shift+X"}, {"Y", "Shift+Y"}, {"Z", "Shift+Z"}}};
            const auto i = static_cast<std::size_t>(axis);
            add("Camera", fmt::format("Look from {}{}", positive ? '+' : '-', "xyz"[i]),
                keys[i][positive ? 0 : 1],
                [this, axis, positive] { setCamera(lookFrom(model().camera(1.0), axis, positive)); });
        }
    }
    add(
        "Time", "Next step", "Right", [this] { goSteps(1); }, true);
    add(
        "Time", "Step before", "Left", [this] { goSteps(-1); }, true);
    add("Time", "First step", "Home",
        [this] { goSteps(-static_cast<std::int64_t>(timed().model.timedLayer().step())); });
    add("Time", "Last step", "End", [this] {
        goSteps(timed().model.timedSteps() - 1 -
                static_cast<std::int64_t>(timed().model.timedLayer().step()));
    });
    add("Time", "Play or pause", "Space", [this] { playback_.playing = !playback_.playing; });
    add("Window", "Panel", "Tab", [this] { panelShown_ = !panelShown_; });
    add("Window", "Film", "K", [this] { filmShown_ = !filmShown_; });
    add("Window", "Numbers", "N", [this] { numbers_.open = !numbers_.open; });
    add("Window", "Full screen", "F11", [this] { window_->toggleFullScreen(); });
    add("Window", "Light or dark", "", [this] { useLight(!isMarked(lightWindow)); });
    add("Window", "Data saver on or off", "", [this] { saveData(!saver_.on); });
    add("Window", "Keys", "?", [this] { keysShown_ = !keysShown_; });
    add("Window", "Commands", "Ctrl+K", [this] { palette_.open(); });
    add("Numbers", "Histogram", "H", [this] { numbers_.toggleHistogram(); });
    const auto addTool = [&](const char* name, const char* keys, PictureTool::Kind kind) {
        add("Numbers", name, keys, [this, kind] {
            lens_.turn(false);
            numbers_.tool().toggle(kind);
        });
    };
    addTool("Lasso", "L", PictureTool::Kind::lasso);
    addTool("Pick a particle", "P", PictureTool::Kind::pick);
    add("Numbers", "Densities of a region", "T", [this] {
        const bool on = !lens_.isOn();
        endTools();
        lens_.turn(on);
    });
    add("Window", "End what is under way", "Escape", [this] {
        endTools();
        setFlying(false);
        keysShown_ = false;
    });
    add("Window", "Connect now", "", [this] {
        connection_.reconnect();
        panes_.reconnectFurther();
    });
    makeViewCommands();
}

void Viewer::makeViewCommands() {
    const auto add = [this](std::string name, const char* keys, std::function<void()> run) {
        commands_.push_back({"Views", std::move(name), keys, std::move(run)});
    };
    add("One view", "Ctrl+1", [this] { setPanes(1); });
    add("Two views", "Ctrl+2", [this] { setPanes(2); });
    add("Four views", "Ctrl+4", [this] { setPanes(4); });
    add("Next view", "V", [this] {
        if (!ImGui::IsAnyMouseDown()) activate((panes_.activeIndex() + 1) % panes_.size());
    });
    const auto link = [&](const char* name, bool Links::*which) {
        add(name, "", [this, which] {
            auto links = panes_.links();
            links.*which = !(links.*which);
            setLinks(links);
        });
    };
    link("Link or unlink steps", &Links::steps);
    link("Link or unlink selections", &Links::selections);
    link("Link or unlink cameras", &Links::cameras);
}

bool Viewer::isMarked(const char* name) {
    std::error_code code;
    return std::filesystem::exists(sessionFolder() / name, code);
}

void Viewer::mark(const char* name, bool marked) {
    const auto path = sessionFolder() / name;
    std::error_code code;
    std::filesystem::create_directories(sessionFolder(), code);
    const bool kept = marked ? std::ofstream(path).good() : (std::filesystem::remove(path, code), !code);
    if (!kept) say(fmt::format("{}: this is not kept for the next time", path.string()));
}

void Viewer::useLight(bool light) {
    window_->setLight(light);
    mark(lightWindow, light);
}

void Viewer::run(const char* command) {
    for (const auto& each : commands_) {
        if (each.name == command) return each.run();
    }
}

/// A direction that the user chose stays; asked again, it is the usual one.
void Viewer::fitView() {
    film_.stop();
    pane().dirty = true;
    const auto camera = model().camera(1.0);
    const bool again = !model().hasCamera() || !model().served() || pane().fitted == camera;
    pane().fitted.reset();
    if (again) return model().fit();
    setCamera(fitAlong(camera, *model().served()));
    pane().fitted = model().camera(1.0);
}

void Viewer::setCamera(const Camera& camera) {
    film_.stop();
    model().setCamera(camera);
    pane().dirty = true;
}

void Viewer::goSteps(std::int64_t steps) {
    const auto wanted = static_cast<std::int64_t>(timed().model.timedLayer().step()) + steps;
    if (steps == 0 || wanted < 0 || wanted >= timed().model.timedSteps()) return;
    timed().model.setTimedStep(static_cast<std::uint32_t>(wanted));
    timed().dirty = true;
}

void Viewer::lookAtDesk() {
    panes_.follow();
    desk_.nameCameras(shelf_.state());
    desk_.look(panes_.looked(), panes_.activeIndex(), panes_.links(), film_.film(), gesture_);
    if (film_.isSaved()) desk_.filmSaved();
}

/// What a pane shows already stays as it is.
void Viewer::restore(const std::optional<DeskState>& state, const char* where) {
    if (!state) return say(fmt::format("There is nothing {}.", where));
    panes_.setIds(state->panes);
    panes_.restoreLinks(state->links);
    if (state->film->revision() != film_.film().revision()) film_.restore(*state->film);
    const auto named = shelf_.restore(state->named);
    if (!named.ok()) say(named.error().toString());
    film_.stop();
    playback_.playing = false;
    for (const auto& was : state->panes) {
        auto& in = *panes_.find(was.id);
        const auto view = was.view();
        const bool same = in.model.isLoaded() == was.fromFile && in.subject == was.subject &&
                          in.model.edited().SerializeAsString() == view.SerializeAsString();
        in.subject = was.subject;
        if (!same) showView(in, view, was.fromFile);
    }
}

void Viewer::showCameras(const std::optional<PaneCameras>& cameras) {
    if (!cameras) return say("There is no other camera.");
    film_.stop();
    for (std::size_t i = 0; i < panes_.size(); ++i) {
        auto& in = panes_[i];
        const auto camera = cameras->all.find(in.id);
        // To the byte, also of one that says less than a camera has.
        auto view = in.model.edited();
        if (camera == cameras->all.end() || camera->second == view.camera().SerializeAsString()) continue;
        view.clear_camera();
        if (!camera->second.empty()) view.mutable_camera()->ParseFromString(camera->second);
        showView(in, view, in.model.isLoaded());
    }
}

void Viewer::keepSession() {
    if (!desk_.isStale() || moving_ || playback_.playing) return;
    for (std::size_t i = 0; i < panes_.size(); ++i) learnLetters(panes_[i].model.edited());
    const auto kept = desk_.writeFile();
    if (!kept.ok()) notes_.add({"This session is not kept: " + kept.error().toString()});
}

void Viewer::offerSession() {
    if (!offered_ || !std::exchange(offersSession_, false)) return;
    const auto age = std::chrono::duration_cast<std::chrono::minutes>(
        std::filesystem::file_time_type::clock::now() - offered_->time);
    const auto ago =
        age.count() < 120 ? fmt::format("{} min", age.count()) : fmt::format("{} h", age.count() / 60);
    notes_.add({fmt::format("Your last session here, {} ago: {}.", ago, offered_->subject),
                {{"Take it up", [this] { takeUpSession(*offered_); }}}});
}

void Viewer::takeUpSession(const Session& session) {
    const Session taken = session;
    const auto view = taken.views.find(taken.subject);
    if (view == taken.views.end()) return;
    desk_.adopt(taken);
    if (taken.film) {
        const auto film = FilmModel::fromScript(*taken.film);
        if (film.ok()) film_.restore(*film);
        if (!film.ok()) say(film.error().toString());
    }
    panes_.restoreLinks(taken.links);
    panes_.setCount(std::max<std::size_t>(taken.panes.size(), 1));
    activate(taken.active);
    for (std::size_t i = 0; i < taken.panes.size(); ++i) {
        panes_[i].subject = taken.panes[i].subject;
        showView(panes_[i], taken.panes[i].view, false);
    }
    pane().subject = taken.subject;
    if (taken.panes.empty()) showView(pane(), view->second, false);
    if (!taken.film) film_.stop();
}

bool Viewer::mayClose() {
    if (closing_ == Closing::agreed) return true;
    if (!window_->shouldClose()) return false;
    if (closing_ == Closing::asked || desk_.unsaved().empty() || options_.exitAfterStill) return true;
    window_->stayOpen();
    closing_ = Closing::asked;
    return false;
}

/// Asks once: what is not saved is kept in the session all the same.
void Viewer::drawClosing() {
    if (closing_ == Closing::no) return;
    constexpr const char* title = "Not saved";
    if (!ImGui::IsPopupOpen(title)) ImGui::OpenPopup(title);
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({display.x / 2.0F, display.y / 3.0F}, ImGuiCond_Always, {0.5F, 0.5F});
    if (!ImGui::BeginPopupModal(title, nullptr, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove))
        return;
    text(fmt::format("Changed since it was opened or saved: {}.", fmt::join(desk_.unsaved(), ", ")));
    text("It is kept, and offered when you come back to this server.");
    const bool close = ImGui::Button("Close");
    ImGui::SameLine();
    const bool save = ImGui::Button("Save view...##closing");
    ImGui::SameLine();
    const bool stay = ImGui::Button("Stay") || ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape));
    if (close) closing_ = Closing::agreed;
    if (save || stay) {
        closing_ = Closing::no;
        ImGui::CloseCurrentPopup();
    }
    ImGui::EndPopup();
    if (save) run("Save view...");
}

/// Where the line of a pane is down and that of the first is not.
std::optional<Note> Viewer::whatOfLine(std::size_t index) {
    const auto& line = panes_.line(index);
    if (index == 0 || line.state() == Connection::State::connected) return std::nullopt;
    const auto why = line.lostReason() ? line.lostReason() : line.brokenBy();
    if (!why) return std::nullopt;
    return Note{why->toString(), {{"Connect now", [this] { run("Connect now"); }}}};
}

/// Where the server does not have what a layer of a pane draws.
std::optional<Note> Viewer::whatOfLayer(std::size_t index, int at) {
    const auto& layer = panes_[index].model.layers().Get(at);
    const auto* entry = findEntry(layer.dataset());
    if (entry == nullptr) {
        Note note{fmt::format("There is no dataset {} on this server.", layer.dataset())};
        note.ways.emplace_back("Remove its layer", [this, at, index] {
            panes_[index].model.removeLayer(at);
            panes_[index].dirty = true;
        });
        return note;
    }
    if (entry->steps() == 0 || layer.step() < entry->steps()) return std::nullopt;
    const auto last = entry->steps() - 1;
    Note note{fmt::format("{} has steps 0 to {}: there is no step {}.", layer.dataset(), last, layer.step())};
    note.ways.emplace_back(fmt::format("Show step {}", last), [this, at, index, last] {
        panes_[index].model.choose(at);
        panes_[index].model.setStep(last);
        panes_[index].dirty = true;
    });
    return note;
}

/// What keeps a pane's view from being shown, and what can be done.
std::vector<Note> Viewer::whatIsWrong(std::size_t index) {
    std::vector<Note> wrong;
    if (!server_.connected) {  // said once
        if (index == 0 && !server_.connection.empty())
            wrong.push_back({server_.connection, {{"Connect now", [this] { run("Connect now"); }}}});
        return wrong;
    }
    if (auto line = whatOfLine(index)) wrong.push_back(*std::move(line));
    const auto& of = panes_[index];
    for (int i = 0; i < of.model.layers().size(); ++i) {
        if (of.model.layers().Get(i).dataset().empty()) continue;
        if (auto layer = whatOfLayer(index, i)) wrong.push_back(*std::move(layer));
    }
    if (wrong.empty() && !of.failure.empty())
        wrong.push_back({of.failure, {{"Undo", [this] { run("Undo"); }}}});
    return wrong;
}

void Viewer::drawTriads(const PictureArea& whole) {
    for (std::size_t i = 0; i < panes_.size(); ++i) {
        const auto& of = panes_[i];
        const auto area = paneArea(whole, i, panes_.size());
        const auto names = of.shown ? axesOf(*of.shown) : std::nullopt;
        const auto end =
            drawTriad(of.model.camera(area.aspect()), names.value_or(AxisNames{"x", "y", "z"}), area);
        if (!end) continue;
        activate(i);
        setCamera(lookFrom(model().camera(1.0), end->axis, end->positive));
    }
}

void Viewer::drawOver(const PictureArea& whole) {
    const float scale = whole.scale;
    drawTriads(whole);
    drawSaver(whole);
    drawPaneFrames(panes_, whole);
    for (std::size_t i = 0; i < panes_.size(); ++i) {
        const auto area = server_.connected ? paneArea(whole, i, panes_.size()) : whole;
        drawWrong(fmt::format("wrong {}", i).c_str(), area, whatIsWrong(i));
    }
    notes_.draw(whole);
    drawAwaited(whole);
    drawKeys(keysShown_, commands_, scale);
    if (const auto* command = palette_.draw(commands_, scale)) {
        ++gesture_;
        command->run();
    }
    browse(whole);
    drawPrompts();
    drawClosing();
}

void Viewer::browse(const PictureArea& area) {
    const auto chosen = browser_.draw(area);
    if (!chosen) return;
    ++gesture_;
    if (chosen->job) return make(*chosen->job);
    if (chosen->use == DatasetBrowser::Use::open) return openDataset(chosen->dataset);
    if (chosen->use == DatasetBrowser::Use::add) return addDataset(chosen->dataset);
    setDataset(chosen->dataset, false);
}

/// Within no other window: what a prompt keeps from the mouse is all the others.
void Viewer::drawPrompts() {
    const float scale = window_->contentScale();
    PanelActions actions;
    actions.openViewFrom = files_.opening.draw(scale);
    actions.saveViewTo = files_.saving.draw(scale);
    actions.openStyleFrom = files_.openingStyle.draw(scale);
    actions.saveStyleTo = files_.savingStyle.draw(scale);
    actions.savePictureTo = files_.savingPicture.draw(scale, [&] { files_.drawPictureChoices(scale); });
    takePaths(actions);
}

}  // namespace mote::client
