// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the user does in the viewer's window.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <utility>

#include "client/shared/script.h"
#include "client/view/camera_control.h"
#include "client/view/viewer.h"

namespace mote::client {

Status Viewer::openView(const std::filesystem::path& path) {
    MOTE_ASSIGN_OR_RETURN(auto saved, readSavedView(path));
    const auto loaded = model_.load(saved.view);
    if (!loaded.ok()) {
        const auto& error = loaded.error();
        return Error{error.code, fmt::format("{}: {}", path.string(), error.where), error.message};
    }
    note_ = std::move(saved.note);
    dirty_ = true;
    return success();
}

Status Viewer::saveView(const std::filesystem::path& path, SameName sameName) {
    const auto area = pictureArea();
    const auto view = model_.saved(area.columns, area.rows);
    MOTE_RETURN_IF_ERROR(saveJson(path, view, sameName));
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
    if (!actions.openViewFrom) return;
    film_.stop();
    const auto opened = openView(*actions.openViewFrom);
    answer(files_.opening, opened);
    if (!opened.ok()) return;
    server_.shown.reset();
    if (model_.hasDataset()) return openDataset(model_.dataset());
    say(std::exchange(note_, {}));
}

float Viewer::filmHeight() const {
    return panelShown_ && filmShown_ ? FilmPanel::height(window_.contentScale()) : 0.0F;
}

Viewer::Area Viewer::pictureArea() const {
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const ImVec2 density = ImGui::GetIO().DisplayFramebufferScale;
    const float panel = panelShown_ ? panelWidth * window_.contentScale() : 0.0F;
    const float width = std::max(display.x - panel, 1.0F), height = std::max(display.y - filmHeight(), 1.0F);
    return {width, height, static_cast<std::uint32_t>(std::max(width * density.x, 1.0F)),
            static_cast<std::uint32_t>(std::max(height * density.y, 1.0F))};
}

void Viewer::takeInput(const Area& area) {
    const ImGuiIO& io = ImGui::GetIO();
    const bool held = ImGui::IsMouseDown(ImGuiMouseButton_Left) ||
                      ImGui::IsMouseDown(ImGuiMouseButton_Right) ||
                      ImGui::IsMouseDown(ImGuiMouseButton_Middle);
    moving_ = held && !io.WantCaptureMouse;
    PanelActions gesture;
    if (numbers_.takeMouse(model_, {area.width, area.height, area.columns, area.rows}, gesture)) {
        dirty_ |= gesture.viewChanged;
        moving_ = false;
        return;
    }
    if (io.WantCaptureMouse) return;
    if (moving_ || io.MouseWheel != 0.0F) film_.stop();
    const double aspect = static_cast<double>(area.columns) / area.rows;
    const glm::dvec2 drag(io.MouseDelta.x / area.height, io.MouseDelta.y / area.height);
    const bool dragged = drag != glm::dvec2(0.0) && held;
    Camera camera = model_.camera(aspect);
    if (dragged && ImGui::IsMouseDown(ImGuiMouseButton_Left) && !io.KeyShift) {
        camera = orbit(camera, drag);
    } else if (dragged) {
        camera = pan(camera, drag);
    }
    if (io.MouseWheel != 0.0F)
        camera = io.KeyCtrl ? zoom(camera, io.MouseWheel) : dolly(camera, io.MouseWheel);
    if (!dragged && io.MouseWheel == 0.0F) return;
    model_.setCamera(camera);
    dirty_ = true;
}

void Viewer::takeKeys() {
    if (ImGui::GetIO().WantTextInput) return;
    const auto pressed = [](ImGuiKey key) { return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key)); };
    // GLFW's codes of letters; a key that stays down switches once.
    const auto letter = [](char key) { return ImGui::IsKeyPressed(key, false); };
    const auto step = static_cast<std::int64_t>(model_.step());
    const auto wanted = step + (pressed(ImGuiKey_RightArrow) ? 1 : 0) - (pressed(ImGuiKey_LeftArrow) ? 1 : 0);
    if (wanted != step && wanted >= 0 && wanted < model_.steps()) {
        model_.setStep(static_cast<std::uint32_t>(wanted));
        dirty_ = true;
    }
    if (pressed(ImGuiKey_Space)) playback_.playing = !playback_.playing;
    if (letter('F')) model_.fit();
    if (letter('O')) model_.setCamera(toggleProjection(model_.camera(1.0)));
    if (letter('F') || letter('O')) film_.stop();
    if (pressed(ImGuiKey_Tab)) panelShown_ = !panelShown_;
    if (letter('K')) filmShown_ = !filmShown_;
    if (letter('N')) numbers_.open = !numbers_.open;
    if (letter('H')) numbers_.toggleHistogram();
    if (letter('L')) numbers_.tool().toggle(PictureTool::Kind::lasso);
    if (letter('P')) numbers_.tool().toggle(PictureTool::Kind::pick);
    if (pressed(ImGuiKey_Escape)) numbers_.tool().setKind(PictureTool::Kind::none);
    dirty_ |= letter('F') || letter('O');
}

void Viewer::apply(const PanelActions& actions) {
    if (actions.viewChanged) film_.stop();
    dirty_ |= actions.viewChanged;
    moving_ |= actions.editing;
    takePaths(actions);
    if (actions.toggleFilm) filmShown_ = !filmShown_;
    if (actions.reconnect) connection_.reconnect();
    if (actions.openDataset) openDataset(*actions.openDataset);
    if (actions.plot) plot(*actions.plot);
    for (const auto& job : server_.jobs) {
        if (job.id() != actions.saveFilm) continue;
        filmShown_ = true;  // it asks where to
        film_.askWhereToSave(job);
    }
    if (actions.cancelJob) {
        connection_.cancelJob(*actions.cancelJob, [this](Result<proto::JobStatus> reply) {
            if (!reply.ok()) say(reply.error().toString());
        });
    }
    if (actions.retryJob) {
        connection_.retryJob(*actions.retryJob, [this](Result<proto::JobStatus> reply) {
            reply.ok() ? replaceJob(*reply) : say(reply.error().toString());
        });
    }
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

void Viewer::play() {
    if (!server_.shown) return;
    const bool seen = server_.frame && server_.frame->view_id() == sentView_;
    const auto step = playback_.next(ImGui::GetTime(), model_.step(), model_.steps(), seen);
    if (!step) return;
    model_.setStep(*step);
    dirty_ = true;
}

const proto::Manifest* Viewer::shownManifest() const {
    return server_.shown ? &server_.shown->manifest() : nullptr;
}

/// What the histogram's window changes of the view, and the numbers that are asked for.
void Viewer::editNumbers(const Area& area) {
    PanelActions actions;
    numbers_.drawOver(model_, shownManifest(), {area.width, area.height, area.columns, area.rows},
                      window_.contentScale(), actions, moving_);
    dirty_ |= actions.viewChanged;
}

/// What a film's bar and its preview change of the view.
void Viewer::editFilm(const Area& area) {
    const double now = ImGui::GetTime();
    if (const auto view = film_.play(now)) showView(*view);
    if (panelShown_ && filmShown_) {
        const auto present = model_.view(area.columns, area.rows);
        const FilmSurroundings around{0.0F, area.height, area.width, window_.contentScale(),
                                      now,  present,     picture_,   server_};
        if (const auto view = film_.draw(around)) showView(*view);
    }
    moving_ |= film_.moving();
    if (still()) film_.askThumbnails();
}

}  // namespace mote::client
