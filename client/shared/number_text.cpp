// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/number_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace mote::client {
namespace {

constexpr std::array<std::string_view, 7> prefixable{"m", "s", "C", "eV", "eV/c", "rad", "A"};

struct Prefix {
    double scale;
    std::string_view letter;
};
constexpr std::array<Prefix, 12> prefixes{{{1e-18, "a"},
                                           {1e-15, "f"},
                                           {1e-12, "p"},
                                           {1e-9, "n"},
                                           {1e-6, "\u00b5"},
                                           {1e-3, "m"},
                                           {1.0, ""},
                                           {1e3, "k"},
                                           {1e6, "M"},
                                           {1e9, "G"},
                                           {1e12, "T"},
                                           {1e15, "P"}}};

/// Rounded to the digits that are shown, so that 999.9999 is no four-digit number of the prefix below.
double rounded(double magnitude) {
    return std::stod(fmt::format("{:.4e}", magnitude));
}

}  // namespace

std::string exactNumber(double value, std::string_view undefined) {
    return std::isfinite(value) ? fmt::format("{}", value) : std::string(undefined);
}

std::string csvField(std::string_view text) {
    if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
    std::string result = "\"";
    for (const char each : text) result += each == '"' ? "\"\"" : std::string(1, each);
    return result + '"';
}

ScaledUnit scaledUnit(double magnitude, std::string_view unit) {
    const ScaledUnit plain{1.0, unit == "1" ? std::string() : std::string(unit)};
    if (std::ranges::find(prefixable, unit) == prefixable.end()) return plain;
    if (!std::isfinite(magnitude) || magnitude == 0.0) return plain;
    const double size = rounded(std::abs(magnitude));
    const auto* chosen = prefixes.begin();
    for (const auto& prefix : prefixes) {
        if (prefix.scale <= size) chosen = &prefix;
    }
    return {chosen->scale, std::string(chosen->letter) + std::string(unit)};
}

std::string shortNumber(double value, const ScaledUnit& unit) {
    if (!std::isfinite(value)) return "-";
    const double scaled = value / unit.scale;
    if (scaled == 0.0) return "0";
    if (scaled == std::trunc(scaled) && std::abs(scaled) < 1e15) return fmt::format("{:.0f}", scaled);
    return fmt::format("{:#.5g}", scaled);
}

std::size_t widthOf(std::string_view text) {
    // Bytes of UTF-8 that begin a letter.
    return static_cast<std::size_t>(std::ranges::count_if(
        text, [](char each) { return (static_cast<unsigned char>(each) & 0xC0U) != 0x80U; }));
}

std::string padLeft(std::string_view text, std::size_t width) {
    const auto own = widthOf(text);
    return std::string(own < width ? width - own : 0, ' ') + std::string(text);
}

std::string padRight(std::string_view text, std::size_t width) {
    const auto own = widthOf(text);
    return std::string(text) + std::string(own < width ? width - own : 0, ' ');
}

}  // namespace mote::client
