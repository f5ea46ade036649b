// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/commands.h"

#include <imgui.h>

#include <algorithm>
#include <cctype>
#include <sstream>
#include <utility>

#include "client/view/panel_widgets.h"

namespace mote::client {
namespace {

/// What the mouse does on the picture.
constexpr std::array<std::pair<const char*, const char*>, 10> mouseHelp{
    {{"drag", "turn about what is under the pointer"},
     {"Shift-drag", "roll"},
     {"right drag, middle drag", "move along"},
     {"wheel", "go there, or away"},
     {"Ctrl-wheel", "another angle of sight"},
     {"W A S D Q E", "while flying: there, aside, down and up"},
     {"drag, wheel", "while flying: look, speed"},
     {"Ctrl-click", "pick a particle"},
     {"click on the triad", "look along that axis"},
     {"right click on a knot", "remove it"}}};

void keyRow(const char* keys, const char* name) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    dim(keys);
    ImGui::TableNextColumn();
    text(name);
}

}  // namespace

std::string loweredLetters(std::string_view text) {
    std::string small(text);
    std::ranges::transform(small, small.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return small;
}

std::vector<std::string> loweredWords(std::string_view typed) {
    std::istringstream in(loweredLetters(typed));
    std::vector<std::string> words;
    for (std::string word; in >> word;) words.push_back(word);
    return words;
}

bool holdsAll(const std::string& text, const std::vector<std::string>& words) {
    return std::ranges::all_of(words, [&](const auto& word) { return text.find(word) != text.npos; });
}

std::vector<const Command*> findCommands(const std::vector<Command>& commands, std::string_view typed) {
    const auto words = loweredWords(typed);
    std::vector<const Command*> found;
    for (const auto& command : commands) {
        if (holdsAll(loweredLetters(command.group + (" " + command.name)), words)) found.push_back(&command);
    }
    std::stable_partition(found.begin(), found.end(), [&](const Command* command) {
        return !words.empty() && loweredLetters(command->name).starts_with(words.front());
    });
    return found;
}

const Command* CommandPalette::drawList(const std::vector<const Command*>& found, bool entered) {
    const Command* wanted = nullptr;
    const auto pressed = [](ImGuiKey key) { return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key)); };
    const int last = static_cast<int>(found.size()) - 1;
    chosen_ += (pressed(ImGuiKey_DownArrow) ? 1 : 0) - (pressed(ImGuiKey_UpArrow) ? 1 : 0);
    chosen_ = std::clamp(chosen_, 0, std::max(last, 0));
    ImGui::BeginChild("found", {0.0F, 12.0F * ImGui::GetTextLineHeightWithSpacing()});
    for (int i = 0; i <= last; ++i) {
        const auto& command = *found[static_cast<std::size_t>(i)];
        ImGui::PushID(i);
        if (ImGui::Selectable(command.name.c_str(), i == chosen_)) wanted = &command;
        ImGui::PopID();
        if (!command.keys.empty()) {
            ImGui::SameLine(ImGui::GetContentRegionAvail().x - 8.5F * ImGui::GetFontSize());
            dim(command.keys);
        }
    }
    if (found.empty()) dim("There is no such command.");
    ImGui::EndChild();
    if (entered && !found.empty()) wanted = found[static_cast<std::size_t>(chosen_)];
    return wanted;
}

const Command* CommandPalette::draw(const std::vector<Command>& commands, float scale) {
    const bool begins = std::exchange(opening_, false);
    if (begins) {
        typed_.fill('\0');
        chosen_ = 0;
        ImGui::OpenPopup("commands");
    }
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({display.x / 2.0F, 60.0F * scale}, ImGuiCond_Always, {0.5F, 0.0F});
    ImGui::SetNextWindowSize({std::min(460.0F * scale, display.x), 0.0F});
    open_ = ImGui::BeginPopup("commands");
    if (!open_) return nullptr;
    if (begins) ImGui::SetKeyboardFocusHere();
    ImGui::SetNextItemWidth(-1.0F);
    const bool entered = ImGui::InputTextWithHint("##typed", "type what you want to do", typed_.data(),
                                                  typed_.size(), ImGuiInputTextFlags_EnterReturnsTrue);
    if (std::exchange(before_, typed_.data()) != typed_.data()) chosen_ = 0;
    const Command* wanted = drawList(findCommands(commands, typed_.data()), entered);
    if (wanted != nullptr || ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape)))
        ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
    return wanted;
}

void drawKeys(bool& shown, const std::vector<Command>& commands, float scale) {
    if (!shown) return;
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({display.x / 2.0F, display.y / 2.0F}, ImGuiCond_Always, {0.5F, 0.5F});
    ImGui::SetNextWindowSize({std::min(860.0F * scale, display.x), 0.0F});
    ImGui::SetNextWindowFocus();
    constexpr auto flags = ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove;
    if (ImGui::Begin("Keys and mouse (? or Esc ends)", &shown, flags)) {
        std::vector<const Command*> keyed;
        for (const auto& command : commands) {
            if (!command.keys.empty()) keyed.push_back(&command);
        }
        ImGui::Columns(2, "halves", false);
        const std::size_t half = (keyed.size() + mouseHelp.size() + 2) / 2;
        const auto table = [&](const char* id, std::size_t from, std::size_t to, bool mouse) {
            if (!ImGui::BeginTable(id, 2)) return;
            ImGui::TableSetupColumn("keys", ImGuiTableColumnFlags_WidthFixed, 105.0F * scale);
            for (std::size_t i = from; i < to; ++i) keyRow(keyed[i]->keys.c_str(), keyed[i]->name.c_str());
            if (mouse) keyRow("", "");
            for (const auto& [keys, name] : mouseHelp) {
                if (mouse) keyRow(keys, name);
            }
            ImGui::EndTable();
        };
        table("left", 0, std::min(half, keyed.size()), false);
        ImGui::NextColumn();
        table("right", std::min(half, keyed.size()), keyed.size(), true);
        ImGui::Columns(1);
    }
    ImGui::End();
}

}  // namespace mote::client
