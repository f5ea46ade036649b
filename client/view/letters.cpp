// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/letters.h"

#include <google/protobuf/message.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>

namespace mote::client {
namespace {

constexpr char32_t lastLatin = 0xFF;  // of those that are always there
constexpr const char* mainFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

struct FontPlace {
    const char* folder;  // of Debian's package
    const char* file;
};

/// Of fonts-noto-cjk, fonts-droid-fallback, fonts-wqy-*, fonts-ipafont-gothic, fonts-nanum.
constexpr std::array<FontPlace, 7> furtherPlaces{
    {{"/usr/share/fonts/opentype/noto", "NotoSansCJK-Regular.ttc"},
     {"/usr/share/fonts-droid-fallback/truetype", "DroidSansFallback.ttf"},
     {"/usr/share/fonts/truetype/droid", "DroidSansFallbackFull.ttf"},
     {"/usr/share/fonts/truetype/wqy", "wqy-microhei.ttc"},
     {"/usr/share/fonts/truetype/wqy", "wqy-zenhei.ttc"},
     {"/usr/share/fonts/opentype/ipafont-gothic", "ipag.ttf"},
     {"/usr/share/fonts/truetype/nanum", "NanumGothic.ttf"}}};

/// Where users keep fonts of their own.
std::filesystem::path ownFonts() {
    const char* data = std::getenv("XDG_DATA_HOME");
    if (data != nullptr && data[0] == '/') return std::filesystem::path(data) / "fonts";
    const char* home = std::getenv("HOME");
    return std::filesystem::path(home != nullptr ? home : "/") / ".local/share/fonts";
}

bool isFont(const std::filesystem::path& path) {
    std::error_code code;
    return std::filesystem::is_regular_file(path, code);
}

/// The letter that begins at `at`, which is moved behind it; 0: none does.
char32_t nextLetter(std::string_view text, std::size_t& at) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned char first = byte(at++);
    if (first < 0x80) return first;
    const int more = first >= 0xF5 ? 0 : first >= 0xF0 ? 3 : first >= 0xE0 ? 2 : first >= 0xC2 ? 1 : 0;
    char32_t letter = first & (0x3F >> more);
    for (int i = 0; i < more; ++i, ++at) {
        if (at >= text.size() || (byte(at) & 0xC0) != 0x80) return 0;
        letter = (letter << 6) | (byte(at) & 0x3F);
    }
    return more > 0 ? letter : 0;
}

void addFont(ImFontAtlas& atlas, const std::filesystem::path& path, float pixels,
             const ImVector<ImWchar>& ranges) {
    ImFontConfig config;
    config.MergeMode = !atlas.Fonts.empty();
    atlas.AddFontFromFileTTF(path.c_str(), pixels, &config, ranges.Data);
}

}  // namespace

void Letters::learn(char32_t letter) {
    const bool half = letter >= 0xD800 && letter < 0xE000;  // of a pair of UTF-16
    if (letter <= lastLatin || half || letter > IM_UNICODE_CODEPOINT_MAX || learned_.size() >= most) return;
    stale_ |= learned_.insert(letter).second;
}

void Letters::learn(std::string_view text) {
    for (std::size_t at = 0; at < text.size();) learn(nextLetter(text, at));
}

void Letters::learn(const google::protobuf::Message& message) {
    using google::protobuf::FieldDescriptor;
    const auto& reflection = *message.GetReflection();
    std::vector<const FieldDescriptor*> fields;
    reflection.ListFields(message, &fields);
    for (const auto* field : fields) {
        const bool texts = field->type() == FieldDescriptor::TYPE_STRING;
        const bool messages = field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
        const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
        for (int i = 0; (texts || messages) && i < count; ++i) {
            if (texts && field->is_repeated()) learn(reflection.GetRepeatedString(message, field, i));
            if (texts && !field->is_repeated()) learn(reflection.GetString(message, field));
            if (messages && field->is_repeated()) learn(reflection.GetRepeatedMessage(message, field, i));
            if (messages && !field->is_repeated()) learn(reflection.GetMessage(message, field));
        }
    }
}

std::vector<std::filesystem::path> Letters::furtherFonts() {
    std::vector<std::filesystem::path> found;
    const auto own = ownFonts();
    for (const auto& [folder, file] : furtherPlaces) {
        for (const auto& path : {std::filesystem::path(folder) / file, own / file}) {
            if (isFont(path)) found.push_back(path);
        }
    }
    return found;
}

void Letters::build(float pixels) {
    stale_ = false;
    auto& atlas = *ImGui::GetIO().Fonts;
    ImFontGlyphRangesBuilder wanted;
    wanted.AddRanges(atlas.GetGlyphRangesDefault());
    for (const char32_t letter : learned_) wanted.AddChar(static_cast<ImWchar>(letter));
    ImVector<ImWchar> ranges;
    wanted.BuildRanges(&ranges);
    const auto begin = [&] {
        atlas.Clear();
        isFont(mainFont) ? addFont(atlas, mainFont, pixels, ranges)
                         : static_cast<void>(atlas.AddFontDefault());
    };
    begin();
    atlas.Build();  // the ranges are its own no longer
    const auto lacks = [font = atlas.Fonts[0]](char32_t letter) {
        return font->FindGlyphNoFallback(static_cast<ImWchar>(letter)) == nullptr;
    };
    const auto further = furtherFonts();
    if (further.empty() || std::ranges::none_of(learned_, lacks)) return;
    begin();
    for (const auto& path : further) addFont(atlas, path, pixels, ranges);
    if (atlas.Build()) return;
    begin();  // one of these files is no font
    atlas.Build();
}

}  // namespace mote::client
