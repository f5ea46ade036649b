// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/over_picture.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "client/view/panel_widgets.h"

namespace mote::client {
namespace {

constexpr auto noteFlags = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                           ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing |
                           ImGuiWindowFlags_NoNav;

/// The way that was chosen, or nothing.
std::function<void()> drawNote(const Note& note, float width) {
    std::function<void()> chosen;
    ImGui::PushTextWrapPos(width);
    ImGui::TextUnformatted(note.sentence.c_str());
    ImGui::PopTextWrapPos();
    for (std::size_t i = 0; i < note.ways.size(); ++i) {
        if (i > 0) ImGui::SameLine();
        if (ImGui::Button(note.ways[i].first.c_str())) chosen = note.ways[i].second;
    }
    return chosen;
}

}  // namespace

void Notes::add(Note note) {
    clear(note.sentence);
    if (news_.size() >= most) news_.erase(news_.begin());
    news_.push_back(std::move(note));
}

void Notes::clear(const std::string& sentence) {
    std::erase_if(news_, [&](const Note& each) { return each.sentence == sentence; });
}

void Notes::draw(const PictureArea& area) {
    if (news_.empty()) return;
    const float width = std::min(430.0F * area.scale, area.width - 20.0F);
    std::function<void()> chosen;
    ImGui::SetNextWindowPos(
        {area.left + area.width - 10.0F * area.scale, area.top + area.height - 10.0F * area.scale},
        ImGuiCond_Always, {1.0F, 1.0F});
    ImGui::SetNextWindowBgAlpha(0.88F);
    ImGui::Begin("news", nullptr, noteFlags | ImGuiWindowFlags_AlwaysAutoResize);
    std::size_t gone = news_.size();
    for (std::size_t i = 0; i < news_.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        if (auto way = drawNote(news_[i], width)) {
            chosen = way;
            gone = i;
        }
        if (!news_[i].ways.empty()) ImGui::SameLine();
        if (ImGui::Button("Put away")) gone = i;
        ImGui::PopID();
    }
    ImGui::End();
    if (gone < news_.size()) news_.erase(news_.begin() + static_cast<std::ptrdiff_t>(gone));
    if (chosen) chosen();
}

void drawWrong(const char* name, const PictureArea& area, const std::vector<Note>& wrong) {
    if (wrong.empty()) return;
    const float width = std::min(430.0F * area.scale, area.width - 20.0F);
    std::function<void()> chosen;
    ImGui::SetNextWindowPos({area.left + area.width / 2.0F, area.top + 40.0F * area.scale}, ImGuiCond_Always,
                            {0.5F, 0.0F});
    ImGui::SetNextWindowBgAlpha(0.92F);
    pushWarningColor();
    ImGui::Begin(name, nullptr, noteFlags | ImGuiWindowFlags_AlwaysAutoResize);
    for (std::size_t i = 0; i < wrong.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        if (auto way = drawNote(wrong[i], width)) chosen = way;
        ImGui::PopID();
    }
    ImGui::End();
    ImGui::PopStyleColor();
    if (chosen) chosen();
}

std::optional<AxisEnd> drawTriad(const Camera& camera, const std::array<std::string, 3>& names,
                                 const PictureArea& area) {
    const float arm = 30.0F * area.scale;
    const ImVec2 middle{area.left + 46.0F * area.scale, area.top + area.height - 46.0F * area.scale};
    const auto toEye = camera.worldToEye();
    std::vector<std::pair<glm::dvec3, AxisEnd>> ends;
    for (int i = 0; i < 6; ++i) {
        glm::dvec4 direction(0.0);
        direction[i / 2] = i % 2 == 0 ? 1.0 : -1.0;
        ends.push_back({glm::dvec3(toEye * direction), {i / 2, i % 2 == 0}});
    }
    std::ranges::sort(ends, {}, [](const auto& end) { return end.first.z; });  // the nearest over the others
    constexpr ImU32 colors[] = {IM_COL32(235, 90, 80, 255), IM_COL32(110, 200, 90, 255),
                                IM_COL32(90, 150, 255, 255)};
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    const auto& io = ImGui::GetIO();
    const bool clicked =
        ImGui::IsMouseReleased(ImGuiMouseButton_Left) && io.MouseDragMaxDistanceSqr[0] < 16.0F;
    std::optional<AxisEnd> chosen;
    for (const auto& [to, end] : ends) {
        const ImVec2 at{middle.x + arm * static_cast<float>(to.x), middle.y - arm * static_cast<float>(to.y)};
        const auto axis = static_cast<std::size_t>(end.axis);
        const bool over = std::hypot(io.MousePos.x - at.x, io.MousePos.y - at.y) < 9.0F * area.scale &&
                          !io.WantCaptureMouse;
        if (end.positive) draw.AddLine(middle, at, colors[axis], 2.0F * area.scale);
        draw.AddCircleFilled(at, (end.positive ? 8.0F : 4.0F) * area.scale,
                             over ? IM_COL32_WHITE : colors[axis]);
        const ImVec2 size = ImGui::CalcTextSize(names[axis].c_str());
        if (end.positive)
            draw.AddText({at.x - size.x / 2.0F, at.y - size.y / 2.0F}, IM_COL32(10, 10, 14, 255),
                         names[axis].c_str());
        if (over && clicked) chosen = end;
    }
    return chosen;
}

bool drawMaking(const PictureArea& area, const std::string& what, double progress, const std::string& phase) {
    const float inset = 14.0F * area.scale;
    ImGui::SetNextWindowPos({area.left + 0.5F * area.width, area.top + area.height - inset}, ImGuiCond_Always,
                            {0.5F, 1.0F});
    ImGui::SetNextWindowSize({std::min(420.0F * area.scale, area.width), 0.0F});
    ImGui::Begin(
        "making", nullptr,
        ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoFocusOnAppearing);
    text(what);
    const auto done = fmt::format("{:.0f}%  {}", 100.0 * progress, phase);
    ImGui::ProgressBar(static_cast<float>(progress), {-80.0F * area.scale, 0.0F}, done.c_str());
    ImGui::SameLine();
    const bool cancelled = ImGui::Button("Cancel");
    ImGui::End();
    return cancelled;
}

void drawSign(const PictureArea& area, const std::string& said) {
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    const float inset = 12.0F * area.scale, half = 0.5F * inset;
    const float wrap = std::max(area.width - 4.0F * inset, 1.0F);
    const ImVec2 size = ImGui::CalcTextSize(said.c_str(), nullptr, false, wrap);
    const ImVec2 at{area.left + 0.5F * (area.width - size.x), area.top + 14.0F * area.scale};
    draw.AddRectFilled({at.x - inset, at.y - half}, {at.x + size.x + inset, at.y + size.y + half},
                       IM_COL32(20, 24, 32, 220), 8.0F * area.scale);
    draw.AddText(ImGui::GetFont(), ImGui::GetFontSize(), at, IM_COL32(235, 240, 250, 255), said.c_str(),
                 nullptr, wrap);
}

void drawFootnote(const PictureArea& area, const std::string& said) {
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    const float inset = 6.0F * area.scale;
    const ImVec2 size = ImGui::CalcTextSize(said.c_str());
    const ImVec2 end{area.left + area.width - inset, area.top + area.height - inset};
    const ImVec2 at{std::max(end.x - inset - size.x, area.left + 2.0F * inset), end.y - inset - size.y};
    draw.AddRectFilled({at.x - inset, at.y - 0.5F * inset}, {end.x, end.y - 0.5F * inset},
                       IM_COL32(20, 24, 32, 220), 4.0F * area.scale);
    draw.AddText(at, IM_COL32(255, 225, 130, 255), said.c_str());
}

}  // namespace mote::client
