// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/film/film_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "client/shared/jobs.h"
#include "client/view/panel_widgets.h"

namespace mote::client {
namespace {

constexpr float stripHeight = 112.0F;                                               // at a scale of 1
constexpr std::array<std::string_view, 3> easingNames{"linear", "smooth", "hold"};  // as Easing counts
constexpr std::array<std::string_view, 2> stepNames{"hold", "blend"};               // as BetweenSteps counts
constexpr std::array<FilmKind, 5> filmKinds{
    {{"mp4", "mp4"}, {"mp4, full colour", "mp4", "full"}, {"webm", "webm"}, {"gif", "gif"}, {"pictures"}}};
constexpr std::array<FilmSize, 5> usualSizes{
    {{640, 360}, {1280, 720}, {1920, 1080}, {2560, 1440}, {3840, 2160}}};

std::string nameOf(FilmSize size) {
    return fmt::format("{} x {}", size.width, size.height);
}

bool button(const char* label, bool enabled) {
    ImGui::BeginDisabled(!enabled);
    const bool pressed = ImGui::Button(label);
    ImGui::EndDisabled();
    return pressed;
}

/// An enumeration that counts as its names; true if another one was chosen.
template <class Enumeration, std::size_t count>
bool choose(const char* label, Enumeration& value, const std::array<std::string_view, count>& names) {
    std::string chosen(names[static_cast<std::size_t>(value)]);
    if (!chooseName(label, chosen, names)) return false;
    value = static_cast<Enumeration>(std::find(names.begin(), names.end(), chosen) - names.begin());
    return true;
}

void chooseSize(FilmModel& model) {
    std::vector<FilmSize> sizes(usualSizes.begin(), usualSizes.end());
    if (std::find(sizes.begin(), sizes.end(), model.size()) == sizes.end()) sizes.push_back(model.size());
    std::vector<std::string> labels;
    labels.reserve(sizes.size());
    for (const auto size : sizes) labels.push_back(nameOf(size));
    const std::vector<std::string_view> names(labels.begin(), labels.end());
    std::string chosen = nameOf(model.size());
    if (!chooseName("##size", chosen, names)) return;
    model.setSize(
        sizes[static_cast<std::size_t>(std::find(names.begin(), names.end(), chosen) - names.begin())]);
}

}  // namespace

float FilmPanel::height(float scale) {
    const ImGuiStyle& style = ImGui::GetStyle();
    const float row = ImGui::GetFrameHeight() + style.ItemSpacing.y;
    return 3.0F * row + stripHeight * scale + style.ItemSpacing.y + 2.0F * style.WindowPadding.y;
}

FilmActions FilmPanel::draw(FilmModel& model, FilmPreview& preview, const FilmState& state,
                            const ThumbnailHandles& thumbnails, float left, float top, float width,
                            float scale) {
    FilmActions actions;
    ImGui::SetNextWindowPos({left, top});
    ImGui::SetNextWindowSize({width, height(scale)});
    ImGui::Begin("film", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoBringToFrontOnFocus |
                     ImGuiWindowFlags_NoFocusOnAppearing);
    drawKeyframeControls(model, state, actions, scale);
    drawPreview(model, preview, state, actions, scale);
    const auto touch = strip_.draw(model, thumbnails, stripHeight * scale, scale);
    actions.selected |= touch == FilmStrip::Touch::selected;
    actions.scrubbed |= touch == FilmStrip::Touch::scrubbed;
    actions.editing |= strip_.held();
    drawFilmControls(model, actions, scale);
    drawFiles(model, state, actions, scale);
    ImGui::End();
    drawPrompts(actions, scale);
    return actions;
}

void FilmPanel::drawKeyframeControls(FilmModel& model, const FilmState& state, FilmActions& actions,
                                     float scale) {
    const bool selected = model.selected().has_value();
    actions.addKeyframe = button("Add keyframe", state.shown);
    ImGui::SameLine();
    actions.replaceKeyframe = button("Replace", state.shown && selected);
    ImGui::SameLine();
    if (button("Duplicate", selected)) {
        const auto done = model.duplicate();
        if (!done.ok()) actions.failure = done.error().toString();
    }
    ImGui::SameLine();
    if (button("Delete", selected)) model.removeSelected();
    ImGui::SameLine(0.0F, 16.0F * scale);
    ImGui::BeginDisabled(!model.selected());
    drawTime(model, actions, scale);
    ImGui::SameLine();
    auto easing = model.selected() ? model.keyframes()[*model.selected()].easing : Easing::linear;
    if (model.constantSpeed()) easing = Easing::linear;
    ImGui::BeginDisabled(model.constantSpeed());
    ImGui::SetNextItemWidth(85.0F * scale);
    if (choose("##easing", easing, easingNames)) model.setEasing(easing);
    ImGui::EndDisabled();
    ImGui::EndDisabled();
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("how the film goes on to the next keyframe");
}

void FilmPanel::drawTime(FilmModel& model, FilmActions& actions, float scale) {
    const auto selected = model.selected();
    double seconds = selected ? model.keyframes()[*selected].seconds : 0.0;
    ImGui::SetNextItemWidth(80.0F * scale);
    if (ImGui::DragScalar("##seconds", ImGuiDataType_Double, &seconds, 0.02F, nullptr, nullptr,
                          "at %.2f s") &&
        selected) {
        model.move(*selected, seconds);
    }
    actions.editing |= ImGui::IsItemActive();
}

void FilmPanel::drawPreview(const FilmModel& model, FilmPreview& preview, const FilmState& state,
                            FilmActions& actions, float scale) {
    const bool playable = model.isFilm() && state.failure.empty();
    ImGui::SameLine(0.0F, 16.0F * scale);
    ImGui::BeginDisabled(!playable && !preview.playing());
    actions.togglePreview = ImGui::Button(preview.playing() ? "Stop" : "Preview", {70.0F * scale, 0.0F});
    ImGui::EndDisabled();
    ImGui::SameLine();
    ImGui::Checkbox("loop", &preview.loop);
    ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
    text(fmt::format("{:.2f} / {:.2f} s", model.playhead(), model.end()));
}

void FilmPanel::drawFilmControls(FilmModel& model, FilmActions& actions, float scale) {
    auto fps = static_cast<float>(model.fps());
    ImGui::SetNextItemWidth(110.0F * scale);
    if (ImGui::DragFloat("##fps", &fps, 0.2F, 1.0F, 240.0F, "%.4g frames/s")) model.setFps(fps);
    actions.editing |= ImGui::IsItemActive();
    ImGui::SameLine();
    ImGui::BeginDisabled(model.empty());
    ImGui::SetNextItemWidth(115.0F * scale);
    chooseSize(model);
    ImGui::EndDisabled();
    ImGui::SameLine();
    bool constant = model.constantSpeed();
    if (ImGui::Checkbox("constant speed", &constant)) model.setConstantSpeed(constant);
    ImGui::SameLine(0.0F, 16.0F * scale);
    ImGui::AlignTextToFramePadding();
    text("steps");
    ImGui::SameLine();
    auto between = model.betweenSteps();
    ImGui::SetNextItemWidth(75.0F * scale);
    if (choose("##steps", between, stepNames)) model.setBetweenSteps(between);
    ImGui::SameLine(0.0F, 16.0F * scale);
    ImGui::AlignTextToFramePadding();
    dim(model.isFilm() ? fmt::format("{} frames", model.frameCount()) : "a film has two keyframes or more");
}

void FilmPanel::drawFiles(const FilmModel& model, const FilmState& state, FilmActions& actions, float scale) {
    if (ImGui::Button("Open script...")) opening.open();
    ImGui::SameLine();
    if (button("Save script...", model.isFilm())) savingScript.open();
    ImGui::SameLine(0.0F, 16.0F * scale);
    const bool busy = state.job != nullptr && isUnderWay(*state.job);
    const bool ready = model.isFilm() && state.failure.empty() && state.connected && !busy;
    if (button("Make film", ready)) actions.makeFilm = &*std::ranges::find(filmKinds, kind_, &FilmKind::name);
    ImGui::SameLine();
    ImGui::SetNextItemWidth(85.0F * scale);
    std::array<std::string_view, filmKinds.size()> names;
    std::ranges::transform(filmKinds, names.begin(), &FilmKind::name);
    chooseName("##kind", kind_, names);
    if (ImGui::IsItemHovered())
        ImGui::SetTooltip(
            "full colour keeps the colours of single points; QuickTime and some builds of Firefox do not "
            "play it");
    ImGui::SameLine(0.0F, 16.0F * scale);
    drawJob(state, actions, scale);
    const auto& sentence = state.failure.empty() ? state.message : state.failure;
    ImGui::AlignTextToFramePadding();
    // One line beside the buttons; the whole of it under the mouse.
    pushWarningColor();
    text(sentence);
    ImGui::PopStyleColor();
    if (!sentence.empty() && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", sentence.c_str());
}

void FilmPanel::drawJob(const FilmState& state, FilmActions& actions, float scale) {
    if (state.saving) {
        ImGui::ProgressBar(static_cast<float>(state.saved), {150.0F * scale, 0.0F}, state.savedWhat.c_str());
        ImGui::SameLine();
        actions.stopSaving = ImGui::Button("Stop");
        ImGui::SameLine();
        return;
    }
    if (state.job == nullptr) return;
    const auto& job = *state.job;
    if (isUnderWay(job)) {
        ImGui::ProgressBar(static_cast<float>(job.progress()), {150.0F * scale, 0.0F}, job.phase().c_str());
        ImGui::SameLine();
        actions.cancelJob = ImGui::Button("Cancel");
        ImGui::SameLine();
    } else if (isReadyFilm(job)) {
        actions.saveFilm = ImGui::Button("Save film...");
        ImGui::SameLine();
    } else if (mayBeTriedAgain(job)) {
        actions.retryJob = ImGui::Button("Try again");
        ImGui::SameLine();
    }
}

void FilmPanel::drawPrompts(FilmActions& actions, float scale) {
    actions.openScript = opening.draw(scale);
    actions.saveScript = savingScript.draw(scale);
    actions.saveFilmTo = savingFilm.draw(scale);
}

}  // namespace mote::client
