// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/text/number.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace mote::prep {
namespace {

constexpr std::size_t maxNumberChars = 128;

bool blank(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

/// strtod, for what is out of range: it says whether that is infinite or nothing. `text` is a number.
double outOfRange(std::string_view text) {
    std::array<char, maxNumberChars + 1> copy{};
    std::copy(text.begin(), text.end(), copy.begin());
    return std::strtod(copy.data(), nullptr);
}

struct Parsed {
    double value = 0.0;
    std::size_t used = 0;  // characters, 0: no number
};

Parsed parsePlain(std::string_view text) {
    Parsed parsed;
    const char* begin = text.data();
    const auto [end, code] = std::from_chars(begin, begin + text.size(), parsed.value);
    if (code == std::errc::invalid_argument) return {};
    parsed.used = static_cast<std::size_t>(end - begin);
    if (code == std::errc::result_out_of_range) {
        if (parsed.used > maxNumberChars) return {};
        parsed.value = outOfRange(text.substr(0, parsed.used));
    }
    return parsed;
}

/// A Fortran number: `text[at]` is the letter of its exponent or, where there is none, the exponent's sign.
std::optional<double> parseFortran(std::string_view text, std::size_t at) {
    if (text.size() >= maxNumberChars) return std::nullopt;
    std::array<char, maxNumberChars + 1> copy{};
    char* end = std::copy(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), copy.begin());
    *end++ = 'e';
    const bool letter = text[at] != '+' && text[at] != '-';
    end = std::copy(text.begin() + static_cast<std::ptrdiff_t>(at + (letter ? 1 : 0)), text.end(), end);
    const std::size_t size = static_cast<std::size_t>(end - copy.data());
    const Parsed parsed = parsePlain({copy.data(), size});
    if (parsed.used != size) return std::nullopt;
    return parsed.value;
}

bool startsFortranExponent(char c) {
    return c == 'd' || c == 'D' || c == 'q' || c == 'Q' || c == '+' || c == '-';
}

std::size_t splitAtBlanks(std::string_view line, std::span<std::string_view> fields) {
    std::size_t count = 0, at = 0;
    while (true) {
        while (at < line.size() && (blank(line[at]) || line[at] == ',')) ++at;
        if (at == line.size()) return count;
        std::size_t end = at;
        if (line[at] == '"') {
            end = std::min(line.find('"', at + 1), line.size());
            if (count < fields.size()) fields[count] = line.substr(at + 1, end - at - 1);
            at = std::min(end + 1, line.size());
        } else {
            while (end < line.size() && !blank(line[end]) && line[end] != ',') ++end;
            if (count < fields.size()) fields[count] = line.substr(at, end - at);
            at = end;
        }
        ++count;
    }
}

}  // namespace

std::string_view trim(std::string_view text) {
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
    return text;
}

std::optional<double> parseNumber(std::string_view text) {
    text = trim(text);
    if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
    const Parsed parsed = parsePlain(text);
    if (parsed.used == 0) return std::nullopt;
    if (parsed.used == text.size()) return parsed.value;
    if (startsFortranExponent(text[parsed.used])) return parseFortran(text, parsed.used);
    return std::nullopt;
}

std::optional<double> parseNumberWithComma(std::string_view text) {
    const std::size_t comma = text.find(',');
    if (comma == std::string_view::npos || text.size() > maxNumberChars) return parseNumber(text);
    std::array<char, maxNumberChars> copy{};
    std::copy(text.begin(), text.end(), copy.begin());
    copy[comma] = '.';
    return parseNumber({copy.data(), text.size()});
}

std::optional<std::uint64_t> parseId(std::string_view text) {
    text = trim(text);
    std::uint64_t id = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), id);
    if (code == std::errc() && end == text.data() + text.size()) return id;
    const auto number = parseNumber(text);
    if (!number || !(*number >= 0.0 && *number < 18446744073709551616.0) || *number != std::floor(*number)) {
        return std::nullopt;
    }
    return static_cast<std::uint64_t>(*number);
}

std::size_t splitFields(std::string_view line, char separator, std::span<std::string_view> fields) {
    if (separator == ' ') return splitAtBlanks(line, fields);
    std::size_t count = 0, at = 0;
    while (true) {
        std::size_t search = at;
        while (search < line.size() && blank(line[search]) && line[search] != separator) ++search;
        const bool quoted = search < line.size() && line[search] == '"';
        if (quoted) search = std::min(line.find('"', search + 1), line.size());
        const std::size_t end = std::min(line.find(separator, search), line.size());
        std::string_view field = trim(line.substr(at, end - at));
        if (quoted && field.size() >= 2 && field.back() == '"') field = field.substr(1, field.size() - 2);
        if (count < fields.size()) fields[count] = field;
        ++count;
        if (end == line.size()) return count;
        at = end + 1;
    }
}

}  // namespace mote::prep
