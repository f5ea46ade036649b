// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/datasets/list_rows.h"

#include <fmt/chrono.h>
#include <imgui.h>

#include <algorithm>
#include <ctime>

namespace mote::client {

std::string dateOf(std::int64_t unixMs) {
    const std::time_t seconds = unixMs / 1000;
    std::tm local{};
    if (unixMs <= 0 || ::localtime_r(&seconds, &local) == nullptr) return {};
    return fmt::format("{:%Y-%m-%d %H:%M}", local);
}

void moveRow(int& row, int count, float height) {
    const auto pressed = [](ImGuiKey key) { return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key)); };
    const int page = std::max(static_cast<int>(ImGui::GetWindowHeight() / height) - 2, 1);
    const int way = (pressed(ImGuiKey_DownArrow) ? 1 : 0) - (pressed(ImGuiKey_UpArrow) ? 1 : 0) +
                    (pressed(ImGuiKey_PageDown) ? page : 0) - (pressed(ImGuiKey_PageUp) ? page : 0);
    row = std::clamp(row + way, 0, std::max(count - 1, 0));
    if (way == 0) return;
    const float top = static_cast<float>(row) * height;
    const float room = ImGui::GetWindowHeight() - 2.0F * height;
    ImGui::SetScrollY(std::clamp(ImGui::GetScrollY(), std::max(top - room, 0.0F), top));
}

}  // namespace mote::client
