// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <set>

#include "client/view/camera_control.h"
#include "client/view/curve_editor.h"
#include "client/view/hybrid_panel.h"
#include "client/view/panel_widgets.h"
#include "client/view/stipple_panel.h"
#include "protocol/scene/color_map.h"

namespace mote::client {
namespace {

const proto::ParticleStepEntry* shownStep(const ViewModel& model, const ServerState& server) {
    if (!server.shown) return nullptr;
    const auto& steps = server.shown->manifest().particles().steps();
    return model.step() < static_cast<std::uint32_t>(steps.size()) ? &steps[static_cast<int>(model.step())]
                                                                   : nullptr;
}

const char* stateName(proto::JobStatus::State state) {
    switch (state) {
        case proto::JobStatus::QUEUED:
            return "queued";
        case proto::JobStatus::RUNNING:
            return "running";
        case proto::JobStatus::SUCCEEDED:
            return "done";
        case proto::JobStatus::FAILED:
            return "failed";
        case proto::JobStatus::CANCELLED:
            return "cancelled";
        default:
            return "unknown";
    }
}

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

/// One of the two curves of a particle plot.
class DensityCurve final : public EditedCurve {
  public:
    DensityCurve(TransferFunctions& functions, TransferFunctions::Which which)
        : functions_(functions), which_(which) {}
    const std::vector<Curve::Knot>& knots() const override { return functions_.knots(which_); }
    void move(std::size_t knot, Curve::Knot to) override { functions_.move(which_, knot, to); }
    std::size_t insert(Curve::Knot at) override { return functions_.insert(which_, at); }
    void remove(std::size_t knot) override { functions_.remove(which_, knot); }

  private:
    TransferFunctions& functions_;
    TransferFunctions::Which which_;
};

}  // namespace

PanelActions Panel::draw(ViewModel& model, Playback& playback, const ServerState& server, float scale) {
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({display.x - width * scale, 0.0F});
    ImGui::SetNextWindowSize({width * scale, display.y});
    ImGui::Begin("panel", nullptr, ImGuiWindowFlags_NoDecoration & ~ImGuiWindowFlags_NoScrollbar);
    ImGui::PushItemWidth(-95.0F * scale);
    PanelActions actions;
    drawConnection(server, actions);
    drawDataset(model, playback, server, actions);
    if (model.stipples()) {
        drawStippleLayer(model, server, actions);
    } else if (model.showsVolume()) {
        drawVolumeLayer(model, server, actions, scale);
    } else {
        drawCurves(model, server, actions, scale);
        drawPoints(model, actions);
    }
    drawCamera(model, actions);
    drawJobs(server, actions);
    ImGui::PopItemWidth();
    ImGui::End();
    return actions;
}

void Panel::drawConnection(const ServerState& server, PanelActions& actions) {
    dim(server.connection);
    if (!server.connected) {
        actions.reconnect = ImGui::Button("Reconnect");
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

void Panel::drawSteps(ViewModel& model, Playback& playback, int steps, PanelActions& actions) {
    int step = static_cast<int>(model.step());
    const bool changed = ImGui::SliderInt("step", &step, 0, steps - 1, "%d", ImGuiSliderFlags_AlwaysClamp);
    if (changed) model.setStep(static_cast<std::uint32_t>(step));
    note(actions, changed);
    if (ImGui::Button(playback.playing ? "Pause (space)" : "Play (space)"))
        playback.playing = !playback.playing;
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-95.0F * ImGui::GetFontSize() / 14.0F);
    ImGui::SliderFloat("steps a second", &playback.stepsPerSecond, 0.5F, 60.0F, "%.1f",
                       ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_Logarithmic);
}

void Panel::drawDataset(ViewModel& model, Playback& playback, const ServerState& server,
                        PanelActions& actions) {
    if (!ImGui::CollapsingHeader("Dataset", ImGuiTreeNodeFlags_DefaultOpen)) return;
    std::vector<std::string_view> names;
    for (const auto& entry : server.catalogue.datasets()) names.emplace_back(entry.name());
    std::string chosen = model.dataset();
    if (chooseName("plot", chosen, names)) actions.openDataset = chosen;
    if (!server.shown) return;
    const int steps = stepCount(server.shown->manifest());
    if (steps > 1) drawSteps(model, playback, steps, actions);
    if (const auto* step = shownStep(model, server)) {
        dim(fmt::format("{}, {} lost, t = {:.4g} s",
                        metric(static_cast<double>(step->particles()), "particles"), step->lost(),
                        step->time()));
    }
    if (model.showsVolume()) return drawHybridFacts(server.shown->manifest(), model.step(), model.hybrid);
    if (model.stipples()) {
        const auto& stipple = server.shown->manifest().stipple();
        dim(fmt::format("{}, {} moves, {} locked", metric(static_cast<double>(stipple.points()), "points"),
                        stipple.moves(), stipple.locked()));
        return;
    }
    drawAxes(server, actions);
}

void Panel::drawAxes(const ServerState& server, PanelActions& actions) {
    const auto shown = axesOf(*server.shown);
    if (!shown) return;
    if (axesOfDataset_ != server.shown->dataset()) {
        axes_ = *shown;
        axesOfDataset_ = server.shown->dataset();
    }
    ImGui::PushItemWidth(78.0F * ImGui::GetFontSize() / 14.0F);
    for (int i = 0; i < 3; ++i) {
        if (i > 0) ImGui::SameLine();
        chooseName(fmt::format("##axis{}", i).c_str(), axes_[static_cast<std::size_t>(i)], plotAxes());
    }
    ImGui::PopItemWidth();
    ImGui::SameLine();
    const bool three = std::set<std::string>(axes_.begin(), axes_.end()).size() == 3;
    const bool possible = three && axes_ != *shown && server.shown->has_replot();
    ImGui::BeginDisabled(!possible);
    if (ImGui::Button("Plot")) actions.plot = axes_;
    ImGui::EndDisabled();
    for (const auto& axis : server.shown->manifest().particles().axes()) {
        dim(fmt::format("{}: {:.4g} to {:.4g} {}", axis.name(), axis.min(), axis.max(), axis.unit()));
    }
    if (!server.shown->has_replot()) dim("Its run is not beneath the server's roots: no other plots.");
}

void Panel::drawStippleLayer(ViewModel& model, const ServerState& server, PanelActions& actions) {
    std::vector<std::string_view> images;
    for (const auto& entry : server.catalogue.datasets()) {
        if (entry.kind() == "image") images.emplace_back(entry.name());
    }
    const bool plane =
        server.shown && server.shown->manifest().stipple().domain() == proto::StippleManifest::PLANE;
    drawStipple(model.stipple, plane, images, actions);
    note(actions, ImGui::ColorEdit3("background", model.background.data(), ImGuiColorEditFlags_NoInputs));
}

void Panel::drawVolumeLayer(ViewModel& model, const ServerState& server, PanelActions& actions, float scale) {
    if (!server.shown) return;
    drawHybrid(model.hybrid, server.shown->manifest().hybrid(), model.step(), model.camera(1.0).eye, actions,
               scale);
    note(actions, ImGui::ColorEdit3("background", model.background.data(), ImGuiColorEditFlags_NoInputs));
}

void Panel::drawCurves(ViewModel& model, const ServerState& server, PanelActions& actions, float scale) {
    if (!ImGui::CollapsingHeader("Transfer functions", ImGuiTreeNodeFlags_DefaultOpen)) return;
    std::span<const std::uint64_t> histogram;
    if (const auto* step = shownStep(model, server)) {
        histogram = {step->density_histogram().data(),
                     static_cast<std::size_t>(step->density_histogram_size())};
    }
    CurveEditorLook look{
        .xName = "log density", .yName = "opacity", .rootAxis = true, .height = 120.0F * scale};
    look.histogram = histogram;
    if (const auto map = ColorMap::find(model.colorMap); map.ok()) look.color = *map;
    text("Volume: opacity over log density");
    DensityCurve volume(model.functions, TransferFunctions::Which::volume);
    note(actions, curveEditor("volume", volume, look));
    actions.editing |= ImGui::IsMouseDown(ImGuiMouseButton_Left) && ImGui::IsAnyItemActive();
    note(actions, chooseName("colours", model.colorMap, ColorMap::names()));
    text("Points: fraction over log density");
    look = {.xName = "log density", .yName = "fraction", .rootAxis = false, .height = 90.0F * scale};
    look.histogram = histogram;
    DensityCurve points(model.functions, TransferFunctions::Which::points);
    note(actions, curveEditor("points", points, look));
    bool linked = model.functions.linked();
    if (ImGui::Checkbox("linked", &linked)) {
        model.functions.setLinked(linked);
        actions.viewChanged = true;
    }
}

void Panel::drawPoints(ViewModel& model, PanelActions& actions) {
    if (!ImGui::CollapsingHeader("Points", ImGuiTreeNodeFlags_DefaultOpen)) return;
    constexpr auto flags = ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_Logarithmic;
    note(actions, ImGui::SliderFloat("opacity", &model.pointOpacity, 0.0005F, 1.0F, "%.4f", flags));
    note(actions, ImGui::SliderFloat("size (pixels)", &model.pointSize, 0.3F, 16.0F, "%.1f", flags));
    note(actions, ImGui::ColorEdit3("colour", model.pointColor.data(), ImGuiColorEditFlags_NoInputs));
    ImGui::SameLine();
    note(actions, ImGui::ColorEdit3("background", model.background.data(), ImGuiColorEditFlags_NoInputs));
}

void Panel::drawCamera(ViewModel& model, PanelActions& actions) {
    if (!ImGui::CollapsingHeader("View", ImGuiTreeNodeFlags_DefaultOpen)) return;
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
    ImGui::SameLine();
    actions.saveView = ImGui::Button("Save view");
    text("from");
    constexpr std::array<const char*, 6> sides{"-x", "+x", "-y", "+y", "-z", "+z"};
    for (std::size_t i = 0; i < sides.size(); ++i) {
        ImGui::SameLine();
        if (!ImGui::Button(sides[i])) continue;
        model.setCamera(lookFrom(model.camera(1.0), static_cast<int>(i / 2), i % 2 != 0));
        actions.viewChanged = true;
    }
}

void Panel::drawJobs(const ServerState& server, PanelActions& actions) {
    if (server.jobs.empty() || !ImGui::CollapsingHeader("Jobs", ImGuiTreeNodeFlags_DefaultOpen)) return;
    constexpr std::size_t most = 6;  // the newest; the panel is no log
    for (std::size_t i = 0; i < std::min(server.jobs.size(), most); ++i) {
        const auto& job = server.jobs[i];
        ImGui::PushID(job.id().c_str());
        text(fmt::format("{}: {}", datasetName(job.request()), stateName(job.state())));
        if (job.state() == proto::JobStatus::RUNNING || job.state() == proto::JobStatus::QUEUED) {
            ImGui::ProgressBar(static_cast<float>(job.progress()), {-70.0F, 0.0F}, job.phase().c_str());
            ImGui::SameLine();
            if (ImGui::SmallButton("Cancel")) actions.cancelJob = job.id();
        }
        if (!job.error().empty()) dim(job.error());
        ImGui::PopID();
    }
}

}  // namespace mote::client
