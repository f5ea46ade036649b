// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/sdds/sdds_command.h"

#include <algorithm>

#include "preprocess/readers/text/number.h"

namespace mote::prep {
namespace {

constexpr std::string_view endWord = "&end";

/// The first place from `at` on where `found` holds outside of quotes; the text's size where there is none.
template <class Condition>
std::size_t findUnquoted(std::string_view text, std::size_t at, Condition found) {
    bool quoted = false;
    for (; at < text.size(); ++at) {
        if (text[at] == '\\' && quoted) {
            ++at;
        } else if (text[at] == '"') {
            quoted = !quoted;
        } else if (!quoted && found(at)) {
            return at;
        }
    }
    return text.size();
}

/// A value without its quotes; a quote inside stands behind a backslash.
std::string unquoted(std::string_view text) {
    text = trim(text);
    if (text.size() < 2 || text.front() != '"' || text.back() != '"') return std::string(text);
    std::string value;
    for (std::size_t i = 1; i + 1 < text.size(); ++i) {
        if (text[i] == '\\' && i + 2 < text.size() && (text[i + 1] == '"' || text[i + 1] == '\\')) ++i;
        value += text[i];
    }
    return value;
}

bool isGap(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

}  // namespace

const std::string* SddsCommand::find(std::string_view field) const {
    for (const auto& [known, value] : fields) {
        if (known == field) return &value;
    }
    return nullptr;
}

std::string_view withoutSddsComment(std::string_view line) {
    return line.substr(0, findUnquoted(line, 0, [&](std::size_t at) { return line[at] == '!'; }));
}

std::optional<std::size_t> sddsCommandEnd(std::string_view text) {
    const std::size_t at = findUnquoted(
        text, 0, [&](std::size_t place) { return text.substr(place, endWord.size()) == endWord; });
    if (at == text.size()) return std::nullopt;
    return at + endWord.size();
}

Result<SddsCommand> SddsCommand::parse(std::string_view text, const std::string& where) {
    SddsCommand command;
    text.remove_suffix(endWord.size());
    const std::size_t nameEnd = std::min(text.find_first_of(" \t\r,"), text.size());
    if (nameEnd < 2 || text[0] != '&') {
        return corrupt(where, "has no command of an SDDS header where one should stand");
    }
    command.name = std::string(text.substr(1, nameEnd - 1));
    for (std::size_t at = nameEnd; at < text.size();) {
        if (isGap(text[at]) || text[at] == ',') {
            ++at;
            continue;
        }
        const std::size_t equals = text.find_first_of("=,\"", at);
        if (equals == std::string_view::npos || text[equals] != '=') {
            return corrupt(where, "has a field without '=' in its command &" + command.name);
        }
        std::size_t begin = equals + 1;
        while (begin < text.size() && isGap(text[begin])) ++begin;
        std::size_t end = findUnquoted(
            text, begin, [&](std::size_t place) { return text[place] == ',' || isGap(text[place]); });
        // Words of a value without quotes go on to the next comma or the next name.
        const std::size_t comma =
            findUnquoted(text, begin, [&](std::size_t place) { return text[place] == ','; });
        if (text.substr(end, comma - end).find_first_of("=\"") == std::string_view::npos) end = comma;
        command.fields.emplace_back(trim(text.substr(at, equals - at)),
                                    unquoted(text.substr(begin, end - begin)));
        at = end;
    }
    return command;
}

}  // namespace mote::prep
