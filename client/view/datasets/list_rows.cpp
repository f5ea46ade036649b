// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/datasets/list_rows.h"

#include <fmt/chrono.h>
#include <imgui.h>

#include <algorithm>
#include <ctime>
#include <utility>

#include "client/view/commands.h"

namespace mote::client {

std::string dateOf(std::int64_t unixMs) {
    const std::time_t seconds = unixMs / 1000;
    std::tm local{};
    if (unixMs <= 0 || ::localtime_r(&seconds, &local) == nullptr) return {};
    return fmt::format("{:%Y-%m-%d %H:%M}", local);
}

void RowSearch::clear() {
    texts_.clear();
    known_ = false;
}

void RowSearch::add(std::string_view text) {
    texts_.push_back(loweredLetters(text));
    known_ = false;
}

const std::vector<int>& RowSearch::find(std::string_view typed, int column, bool descending,
                                        const Compare& compare) {
    if (std::exchange(known_, true) && typed == typed_ && column == column_ && descending == descending_)
        return found_;
    typed_ = typed;
    column_ = column;
    descending_ = descending;
    const auto words = loweredWords(typed);
    found_.clear();
    for (std::size_t i = 0; i < texts_.size(); ++i) {
        if (holdsAll(texts_[i], words)) found_.push_back(static_cast<int>(i));
    }
    std::ranges::stable_sort(found_, [&](int one, int other) {
        const int order = compare(column, one, other);
        return descending ? order > 0 : order < 0;
    });
    return found_;
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
