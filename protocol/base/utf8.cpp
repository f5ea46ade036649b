// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/base/utf8.h"

#include <algorithm>
#include <cstdint>

namespace mote {
namespace {

/// Each control character but the `kept` ones replaced, bytes of no character "?".
std::string shown(std::string_view text, std::string_view kept, std::string (*replace)(std::string_view)) {
    std::string result;
    result.reserve(text.size());
    while (!text.empty()) {
        const std::size_t length = characterLength(text);
        const auto character = text.substr(0, std::max<std::size_t>(length, 1));
        if (length == 0) {
            result += '?';
        } else if (isControl(character) && kept.find(character[0]) == std::string_view::npos) {
            result += replace(character);
        } else {
            result += character;
        }
        text.remove_prefix(character.size());
    }
    return result;
}

/// By its code point, which is the last byte of C0 and C1 alike.
std::string escaped(std::string_view control) {
    constexpr const char* digits = "0123456789abcdef";
    const auto code = static_cast<std::uint8_t>(control.back());
    return {'\\', 'x', digits[code >> 4], digits[code & 15]};
}

}  // namespace

std::size_t characterLength(std::string_view text) {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
    const auto within = [&](std::size_t i, std::uint8_t least, std::uint8_t greatest) {
        return i < text.size() && byte(i) >= least && byte(i) <= greatest;
    };
    const std::uint8_t first = byte(0);
    if (first < 0x80) return 1;
    if (first >= 0xc2 && first <= 0xdf) return within(1, 0x80, 0xbf) ? 2 : 0;
    if (first >= 0xe0 && first <= 0xef) {
        const std::uint8_t least = first == 0xe0 ? 0xa0 : 0x80;
        const std::uint8_t greatest = first == 0xed ? 0x9f : 0xbf;
        return within(1, least, greatest) && within(2, 0x80, 0xbf) ? 3 : 0;
    }
    if (first >= 0xf0 && first <= 0xf4) {
        const std::uint8_t least = first == 0xf0 ? 0x90 : 0x80;
        const std::uint8_t greatest = first == 0xf4 ? 0x8f : 0xbf;
        return within(1, least, greatest) && within(2, 0x80, 0xbf) && within(3, 0x80, 0xbf) ? 4 : 0;
    }
    return 0;
}

bool isUtf8(std::string_view text) {
    while (!text.empty()) {
        const std::size_t length = characterLength(text);
        if (length == 0) return false;
        text.remove_prefix(length);
    }
    return true;
}

std::string toUtf8(std::string_view text) {
    std::string result;
    result.reserve(text.size());
    while (!text.empty()) {
        const std::size_t length = characterLength(text);
        if (length == 0) result += '?';
        result += text.substr(0, length);
        text.remove_prefix(length == 0 ? 1 : length);
    }
    return result;
}

bool isControl(std::string_view character) {
    const auto first = static_cast<std::uint8_t>(character[0]);
    if (character.size() == 2) return first == 0xc2 && static_cast<std::uint8_t>(character[1]) < 0xa0;
    return character.size() == 1 && (first < 0x20 || first == 0x7f);
}

std::string toTerminalText(std::string_view text) {
    return shown(text, "", escaped);
}

std::string toTerminalLines(std::string_view text) {
    return shown(text, "\n\t", escaped);
}

std::string toLogText(std::string_view text) {
    constexpr std::size_t longest = 500;
    return shown(text.substr(0, longest), "", [](std::string_view) { return std::string("?"); });
}

std::string lower(std::string_view text) {
    std::string made(text);
    for (char& c : made) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return made;
}

}  // namespace mote
