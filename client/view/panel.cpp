// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <vector>

#include "client/shared/jobs.h"
#include "client/view/camera_control.h"
#include "protocol/scene/dataset.h"

namespace mote::client {
namespace {

const char* encodingName(proto::Frame::Encoding encoding) {
    switch (encoding) {
        case proto::Frame::ZSTD:
            return "lossless";
        case proto::Frame::H264:
            return "H.264";
        default:
            return "JPEG";
    }
}

/// Beyond a gigabit a second a link is as good as none.
std::string linkName(double bytesPerSecond) {
    if (bytesPerSecond <= 0.0) return "not measured";
    return bytesPerSecond > 125e6 ? "local" : metric(8.0 * bytesPerSecond, "bit/s");
}

void drawConnection(const ServerState& server, PanelActions& actions) {
    dim(server.connection);
    if (!server.connected) {
        actions.reconnect = ImGui::Button("Connect now");
    } else {
        text(fmt::format("{:.1f} frames/s   {:.1f} ms   {}", server.framesPerSecond, server.roundTripMs,
                         metric(server.bytesPerSecond, "B/s")));
    }
    if (server.frame) {
        const auto& frame = *server.frame;
        text(fmt::format("{}   {} x {}   {}", metric(static_cast<double>(frame.points_drawn()), "points"),
                         frame.width(), frame.height(), frame.final() ? "exact" : "refining"));
        text(fmt::format("{}   link {}", encodingName(frame.encoding()),
                         linkName(frame.link_bytes_per_second())));
    }
    if (!server.message.empty()) {
        ImGui::PushStyleColor(ImGuiCol_Text, IM_COL32(255, 150, 110, 255));
        ImGui::TextWrapped("%s", server.message.c_str());
        ImGui::PopStyleColor();
    }
}

/// What a loaded view says of steps that the slider cannot show.
void drawOddStep(ViewModel& model, PanelActions& actions) {
    const auto last = static_cast<std::uint32_t>(std::max(model.steps(), 1)) - 1;
    if (const auto towards = model.towards())
        dim(fmt::format("{:.4g}% of the way to step {}", 100.0 * towards->share(), towards->step()));
    if (model.step() <= last) return;
    dim(fmt::format("The view shows step {}, which the dataset does not have.", model.step()));
    if (!ImGui::Button(fmt::format("Show step {}", last).c_str())) return;
    model.setStep(last);
    actions.viewChanged = true;
}

void drawSteps(ViewModel& model, Playback& playback, PanelActions& actions) {
    const auto last = static_cast<std::uint32_t>(model.steps()) - 1, least = 0U;
    std::uint32_t step = model.step();
    const bool moved = ImGui::SliderScalar("step", ImGuiDataType_U32, &step, &least, &last, "%u",
                                           ImGuiSliderFlags_AlwaysClamp);
    note(actions, moved);
    if (moved) model.setStep(step);
    if (ImGui::Button(playback.playing ? "Pause (space)" : "Play (space)"))
        playback.playing = !playback.playing;
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-95.0F * ImGui::GetFontSize() / 14.0F);
    ImGui::SliderFloat("steps a second", &playback.stepsPerSecond, 0.5F, 60.0F, "%.1f",
                       ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_Logarithmic);
}

/// Where several kinds of layers draw the dataset.
void drawKinds(ViewModel& model, const proto::Manifest& manifest, PanelActions& actions) {
    const auto kinds = layersThatDraw(manifest.kind());
    // A loaded view may say one that does not.
    const bool drawn = std::find(kinds.begin(), kinds.end(), model.kind()) != kinds.end();
    if (kinds.size() < 2 || !drawn) return;
    const auto nameOf = [](proto::Layer::KindCase kind) -> std::string_view {
        return proto::Layer::descriptor()->FindFieldByNumber(kind)->name();
    };
    std::vector<std::string_view> names;
    for (const auto kind : kinds) names.push_back(nameOf(kind));
    std::string chosen(nameOf(model.kind()));
    nameList(actions, "drawn as", chosen, names);
    model.drawAs(
        kinds[static_cast<std::size_t>(std::find(names.begin(), names.end(), chosen) - names.begin())],
        manifest);
}

/// `facts`: also what the shown step holds, and its axes.
void drawDataset(ViewModel& model, Playback& playback, LayerPanel& layer, bool facts) {
    if (!section("Dataset")) return;
    std::vector<std::string_view> names;
    for (const auto& entry : layer.server.catalogue.datasets()) names.emplace_back(entry.name());
    std::string chosen = model.dataset();
    if (chooseName("plot", chosen, names)) layer.actions.openDataset = chosen;
    if (!layer.server.shown) return;
    if (model.steps() > 1) drawSteps(model, playback, layer.actions);
    drawOddStep(model, layer.actions);
    layer.step = model.step();
    if (!facts) return;
    drawKinds(model, layer.server.shown->manifest(), layer.actions);
    model.editor().drawFacts(layer);
}

void drawFiles(ViewFiles& files, PanelActions& actions, float scale) {
    if (ImGui::Button("Open view...")) files.opening.open();
    ImGui::SameLine();
    if (ImGui::Button("Save view..."))
        files.saving.open(files.saving.hasPath() ? "" : freshPath("view.json"));
    actions.openViewFrom = files.opening.draw(scale);
    actions.saveViewTo = files.saving.draw(scale);
}

void drawCamera(ViewModel& model, PanelActions& actions) {
    if (!section("View")) return;
    if (ImGui::Button("Fit (F)")) {
        model.fit();
        actions.viewChanged = true;
    }
    ImGui::SameLine();
    const auto camera = model.camera(1.0);
    if (ImGui::Button(camera.perspective() ? "Orthographic (O)" : "Perspective (O)")) {
        model.setCamera(toggleProjection(camera));
        actions.viewChanged = true;
    }
    actions.toggleFilm = ImGui::Button("Film (K)");
    ImGui::SameLine();
    text("from");
    constexpr std::array<const char*, 6> sides{"-x", "+x", "-y", "+y", "-z", "+z"};
    for (std::size_t i = 0; i < sides.size(); ++i) {
        ImGui::SameLine();
        if (!ImGui::Button(sides[i])) continue;
        model.setCamera(lookFrom(model.camera(1.0), static_cast<int>(i / 2), i % 2 != 0));
        actions.viewChanged = true;
    }
}

void drawJobs(const ServerState& server, PanelActions& actions) {
    if (server.jobs.empty() || !section("Jobs")) return;
    constexpr float lines = 18.0F;  // the panel is no log: older ones are scrolled to
    const ImVec2 most(0.0F, lines * ImGui::GetTextLineHeightWithSpacing());
    const bool scrolls = server.jobs.size() > 6;
    if (scrolls) ImGui::BeginChild("jobs", most);
    for (const auto& job : server.jobs) {
        ImGui::PushID(job.id().c_str());
        text(fmt::format("{}: {}", jobName(job.request()), stateName(job.state())));
        if (isUnderWay(job)) {
            ImGui::ProgressBar(static_cast<float>(job.progress()), {-70.0F, 0.0F}, job.phase().c_str());
            ImGui::SameLine();
            if (ImGui::SmallButton("Cancel")) actions.cancelJob = job.id();
        }
        if (isReadyFilm(job) && ImGui::SmallButton("Save film...")) actions.saveFilm = job.id();
        if (mayBeTriedAgain(job) && ImGui::SmallButton("Try again")) actions.retryJob = job.id();
        if (!job.error().empty()) dim(job.error());
        ImGui::PopID();
    }
    if (server.jobs.size() < server.allJobs && ImGui::SmallButton("Older jobs...")) actions.moreJobs = true;
    if (scrolls) ImGui::EndChild();
}

/// Two sides of the panel, as tabs where the layer has numbers.
void drawSides(ViewModel& model, NumbersEditor& numbers, ViewFiles& files, LayerPanel& layer) {
    const auto drawPicture = [&] {
        if (model.kind() != proto::Layer::KIND_NOT_SET) model.editor().draw(layer);
        drawCamera(model, layer.actions);
        drawFiles(files, layer.actions, layer.scale);
        drawJobs(layer.server, layer.actions);
    };
    if (!layer.server.shown || model.kind() != proto::Layer::kParticles) return drawPicture();
    const float gap = ImGui::GetStyle().ItemSpacing.x;
    const float width = 0.5F * (ImGui::GetContentRegionAvail().x - gap);
    const char* labels[] = {"Picture", "Numbers (N)"};
    for (const bool side : {false, true}) {
        if (side) ImGui::SameLine();
        const bool chosen = numbers.open == side;
        if (chosen) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_ButtonActive));
        if (ImGui::Button(labels[side ? 1 : 0], {width, 0.0F})) numbers.open = side;
        if (chosen) ImGui::PopStyleColor();
    }
    if (!numbers.open) return drawPicture();
    numbers.drawPanel(model, layer.server.shown->manifest(), layer.scale, layer.actions);
}

}  // namespace

PanelActions drawPanel(ViewModel& model, Playback& playback, NumbersEditor& numbers, ViewFiles& files,
                       const ServerState& server, float scale) {
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({display.x - panelWidth * scale, 0.0F});
    ImGui::SetNextWindowSize({panelWidth * scale, display.y});
    ImGui::Begin("panel", nullptr, ImGuiWindowFlags_NoDecoration & ~ImGuiWindowFlags_NoScrollbar);
    ImGui::PushItemWidth(-95.0F * scale);
    PanelActions actions;
    LayerPanel layer{server, model.step(), model.camera(1.0).eye, scale, model.background, actions};
    drawConnection(server, actions);
    // Numbers need the room.
    drawDataset(model, playback, layer, !(numbers.open && model.kind() == proto::Layer::kParticles));
    drawSides(model, numbers, files, layer);
    ImGui::PopItemWidth();
    ImGui::End();
    return actions;
}

}  // namespace mote::client
