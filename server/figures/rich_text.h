// SPDX-License-Identifier: GPL-3.0-or-later
//
// RichText: a line of text as papers set it: some of it italic, some raised or lowered. A value; pure
// functions, any thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace mote::server {

enum class Script {
    normal,
    below,  ///< an index
    above,  ///< an exponent
};

struct TextRun {
    std::string text;  ///< UTF-8, or what comes as such: bytes that belong to no character are shown as "?"
    bool italic = false;
    Script script = Script::normal;

    bool operator==(const TextRun&) const = default;
};

using RichText = std::vector<TextRun>;

inline RichText upright(std::string text) {
    return {{std::move(text), false, Script::normal}};
}
inline RichText italic(std::string text) {
    return {{std::move(text), true, Script::normal}};
}

RichText operator+(RichText first, const RichText& second);

/// As a line of plain text: indices follow "_" and exponents "^".
std::string toPlain(const RichText& text);

/// "−12": a number's text with the minus sign that belongs there, not a hyphen.
std::string withMinusSign(std::string_view number);

}  // namespace mote::server
