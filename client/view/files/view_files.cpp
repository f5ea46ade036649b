// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/files/view_files.h"

#include <fmt/format.h>
#include <imgui.h>
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <utility>

#include "client/view/desk.h"
#include "client/view/panel_widgets.h"

namespace mote::client {

std::filesystem::path expandHome(const std::string& typed) {
    const char* home = std::getenv("HOME");
    if (home == nullptr || !typed.starts_with("~/")) return typed;
    return std::filesystem::path(home) / typed.substr(2);
}

namespace {

/// As a shell reads it, which ends at a quote.
std::string shellWord(std::string_view word) {
    std::string text = "'";
    for (const char letter : word) text += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
    return text + "'";
}

}  // namespace

std::string commandOf(const std::filesystem::path& view, const std::filesystem::path& connection,
                      const std::vector<std::string>& spawn) {
    auto command = fmt::format("mote-frames {}", shellWord(view.string()));
    if (spawn.empty()) command += " --connect " + shellWord(connection.string());
    for (const auto& root : spawn) command += " --spawn " + shellWord(root);
    return command + " --out .";
}

std::string keptWish(const char* name) {
    std::ifstream in(sessionFolder() / name);
    std::string line;
    std::getline(in, line);
    return line;
}

bool keepWish(const char* name, const std::string& line) {
    std::error_code code;
    std::filesystem::create_directories(sessionFolder(), code);
    std::ofstream out(sessionFolder() / name);
    return (out << line << '\n').flush().good();
}

PathPrompt::PathPrompt(std::string title, std::string verb, const std::string& usual, bool mayReplace)
    : title_(std::move(title)), verb_(std::move(verb)), mayReplace_(mayReplace) {
    offer(usual);
}

void PathPrompt::offer(const std::string& path) {
    typed_.fill('\0');
    std::copy_n(path.begin(), std::min(path.size(), typed_.size() - 1), typed_.begin());
}

void PathPrompt::open(const std::filesystem::path& usual) {
    const std::filesystem::path typed(typed_.data());
    if (!usual.empty() && (typed.empty() || typed.extension() != usual.extension())) offer(usual.string());
    opening_ = focusing_ = true;
    closing_ = false;
    failure_.clear();
    agreed_.clear();
}

void PathPrompt::fail(std::string sentence) {
    failure_ = std::move(sentence);
    focusing_ = true;
}

std::optional<std::filesystem::path> PathPrompt::decide(bool pressed) {
    const auto path = expandHome(typed_.data());
    if (!pressed) return std::nullopt;
    failure_.clear();
    if (path.empty()) {
        fail("a path is needed");
        return std::nullopt;
    }
    std::error_code code;
    const auto type = std::filesystem::symlink_status(path, code).type();
    const bool free = type == std::filesystem::file_type::not_found;
    if (mayReplace_ && agreed_ != path && !free && !std::filesystem::is_directory(path, code)) {
        agreed_ = path;
        fail(fmt::format("{} is there already; once more to replace it", path.string()));
        return std::nullopt;
    }
    return path;
}

std::optional<std::filesystem::path> PathPrompt::draw(float scale, const std::function<void()>& more) {
    if (std::exchange(opening_, false)) ImGui::OpenPopup(title_.c_str());
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({display.x / 2.0F, display.y / 3.0F}, ImGuiCond_Always, {0.5F, 0.5F});
    ImGui::SetNextWindowSize({std::min(520.0F * scale, display.x), 0.0F});
    constexpr auto flags = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize;
    if (!ImGui::BeginPopupModal(title_.c_str(), nullptr, flags)) return std::nullopt;
    if (std::exchange(focusing_, false)) ImGui::SetKeyboardFocusHere();
    ImGui::SetNextItemWidth(-1.0F);
    const bool entered =
        ImGui::InputText("##path", typed_.data(), typed_.size(), ImGuiInputTextFlags_EnterReturnsTrue);
    if (more) more();
    const bool pressed = ImGui::Button(verb_.c_str()) || entered;
    ImGui::SameLine();
    const bool given = ImGui::Button("Cancel") || ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape));
    auto path = decide(pressed && !given);
    if (!failure_.empty()) {
        pushWarningColor();
        ImGui::TextWrapped("%s", failure_.c_str());
        ImGui::PopStyleColor();
    }
    if (given || std::exchange(closing_, false)) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
    return path;
}

void ViewFiles::drawPictureChoices(float scale) {
    constexpr std::array<const char*, 3> names{"as it is shown", "without its background",
                                               "the whole window, with its panel"};
    auto chosen = static_cast<int>(pictureOf);
    ImGui::SetNextItemWidth(260.0F * scale);
    ImGui::Combo("##of", &chosen, names.data(), static_cast<int>(names.size()));
    pictureOf = static_cast<PictureOf>(chosen);
    ImGui::BeginDisabled(pictureOf == PictureOf::window);
    ImGui::SetNextItemWidth(160.0F * scale);
    ImGui::InputInt2("pixels across and down", pictureSize.data());
    ImGui::EndDisabled();
}

std::filesystem::path freshPath(const std::filesystem::path& usual) {
    constexpr int most = 10000;  // then one is offered that the user is asked about
    std::error_code code;
    auto path = usual;
    for (int number = 2; number <= most; ++number) {
        if (std::filesystem::symlink_status(path, code).type() == std::filesystem::file_type::not_found)
            break;
        path = usual;
        path.replace_filename(
            fmt::format("{}-{}{}", usual.stem().string(), number, usual.extension().string()));
    }
    return path;
}

}  // namespace mote::client
