// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/time_bar.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace mote::client {
namespace {

constexpr int mostTicks = 200;

void tooltipOf(const char* said) {
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", said);
}

/// Every so many steps there is a tick, so that they can be told apart.
int tickStride(int steps, float width) {
    const int most = std::clamp(static_cast<int>(width / 5.0F), 2, mostTicks);
    int stride = 1;
    for (int factor = 0; steps / stride > most; ++factor) stride *= factor % 3 == 1 ? 5 : 2;
    return stride;
}

}  // namespace

std::vector<double> stepTimes(const proto::Manifest& manifest) {
    std::vector<double> times;
    for (const auto& step : manifest.particles().steps()) times.push_back(step.time());
    for (const auto& step : manifest.hybrid().steps()) times.push_back(step.time());
    const bool finite = std::ranges::all_of(times, [](double time) { return std::isfinite(time); });
    if (!finite || std::ranges::adjacent_find(times, std::greater_equal<>()) != times.end()) return {};
    return times;
}

void TimeBar::drawTrack(ViewModel& model, const std::vector<double>& times, float width,
                        PanelActions& actions) const {
    const int steps = model.timedSteps();
    const bool timed = byTime_ && times.size() == static_cast<std::size_t>(steps);
    const auto shareOf = [&](int step) {
        if (!timed) return static_cast<double>(step) / (steps - 1);
        const auto at = static_cast<std::size_t>(step);
        return (times[at] - times.front()) / (times.back() - times.front());
    };
    const ImVec2 origin = ImGui::GetCursorScreenPos();
    const float height = ImGui::GetFrameHeight(), edge = 0.5F * ImGui::GetFontSize();
    const float room = std::max(width - 2.0F * edge, 1.0F);
    ImGui::InvisibleButton("track", {width, height});
    note(actions, false);
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const auto across = [&](int step) { return origin.x + edge + room * static_cast<float>(shareOf(step)); };
    draw.AddRectFilled(origin, {origin.x + width, origin.y + height}, IM_COL32(24, 30, 42, 255), 4.0F);
    const int stride = tickStride(steps, room);
    for (int step = 0; step < steps; step += stride)
        draw.AddLine({across(step), origin.y + 0.55F * height}, {across(step), origin.y + height},
                     IM_COL32(255, 255, 255, 70));
    const auto shown = std::min(static_cast<int>(model.timedLayer().step()), steps - 1);
    draw.AddRectFilled({across(shown) - 0.4F * edge, origin.y},
                       {across(shown) + 0.4F * edge, origin.y + height}, IM_COL32(90, 160, 255, 255), 3.0F);
    if (!ImGui::IsItemActive()) return;
    int nearest = 0;
    const float mouse = ImGui::GetIO().MousePos.x;
    for (int step = 1; step < steps; ++step) {
        if (std::abs(across(step) - mouse) < std::abs(across(nearest) - mouse)) nearest = step;
    }
    if (nearest == static_cast<int>(model.timedLayer().step())) return;
    model.setTimedStep(static_cast<std::uint32_t>(nearest));
    actions.viewChanged = true;
}

void TimeBar::draw(ViewModel& model, Playback& playback, const std::vector<double>& times,
                   const TimeBarPlace& place, PanelActions& actions) {
    ImGui::SetNextWindowPos({place.left, place.top});
    ImGui::SetNextWindowSize({place.width, height(place.scale)});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {8.0F * place.scale, 6.0F * place.scale});
    ImGui::Begin("time", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoBringToFrontOnFocus |
                     ImGuiWindowFlags_NoFocusOnAppearing);
    ImGui::PopStyleVar();
    const auto button = [&](const char* label, const char* command) {
        if (ImGui::Button(label)) actions.command = command;
        tooltipOf(command);
        ImGui::SameLine(0.0F, 4.0F * place.scale);
    };
    button("|<##time", "First step");
    button("<##time", "Step before");
    button(playback.playing ? "Pause" : "Play", "Play or pause");
    button(">##time", "Next step");
    button(">|##time", "Last step");
    const auto shown = static_cast<std::size_t>(model.timedLayer().step());
    std::string said = fmt::format("step {} of {}", shown, model.timedSteps() - 1);
    if (shown < times.size()) said += fmt::format(", t = {:.5g} s", times[shown]);
    ImGui::AlignTextToFramePadding();
    text(said);
    const float behind = ImGui::GetItemRectMax().x - ImGui::GetWindowPos().x;
    ImGui::SameLine(std::max(300.0F * place.scale, behind + 8.0F * place.scale));
    const float rest = 330.0F * place.scale;
    drawTrack(model, times, std::max(ImGui::GetContentRegionAvail().x - rest, 40.0F), actions);
    ImGui::SameLine();
    ImGui::Checkbox("back", &playback.backwards);
    tooltipOf("play from the last step to the first");
    ImGui::SameLine();
    ImGui::Checkbox("loop", &playback.loop);
    tooltipOf("begin again at the other end");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(42.0F * place.scale);
    ImGui::DragInt("##stride", &playback.stride, 0.1F, 1, 1000, "x%d", ImGuiSliderFlags_AlwaysClamp);
    tooltipOf("steps at a time, while it is played");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(62.0F * place.scale);
    ImGui::DragFloat("##speed", &playback.stepsPerSecond, 0.1F, 0.5F, 60.0F, "%.1f/s",
                     ImGuiSliderFlags_AlwaysClamp);
    tooltipOf("steps a second");
    ImGui::SameLine();
    ImGui::BeginDisabled(times.empty());
    ImGui::Checkbox("time", &byTime_);
    ImGui::EndDisabled();
    tooltipOf("ticks lie where the steps lie in time");
    ImGui::End();
}

}  // namespace mote::client
