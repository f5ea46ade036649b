// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/rich_text.h"

namespace mote::server {

RichText operator+(RichText first, const RichText& second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
}

std::string toPlain(const RichText& text) {
    std::string plain;
    Script before = Script::normal;
    for (const auto& run : text) {
        if (run.script != before && run.script == Script::below) plain += '_';
        if (run.script != before && run.script == Script::above) plain += '^';
        plain += run.text;
        before = run.script;
    }
    return plain;
}

std::string withMinusSign(std::string_view number) {
    std::string text;
    for (const char c : number) {
        if (c == '-')
            text += "\u2212";
        else
            text += c;
    }
    return text;
}

}  // namespace mote::server
