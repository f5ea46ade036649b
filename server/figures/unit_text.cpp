// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/unit_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace mote::server {
namespace {

/// Which prefixes a unit takes; nobody writes kiloseconds or megametres of a beam.
struct Prefixed {
    std::string_view unit;
    int least, greatest;
};
constexpr std::array prefixed{Prefixed{"m", -15, 3},    Prefixed{"s", -18, 0},     Prefixed{"eV", -3, 18},
                              Prefixed{"eV/c", -3, 18}, Prefixed{"eV/c^2", 0, 18}, Prefixed{"C", -18, 3},
                              Prefixed{"rad", -9, 0},   Prefixed{"A", -9, 9},      Prefixed{"V", -9, 12},
                              Prefixed{"V/m", -3, 15},  Prefixed{"J", -15, 9},     Prefixed{"T", -9, 3},
                              Prefixed{"Hz", 0, 18},    Prefixed{"W", -15, 15},    Prefixed{"m rad", -15, 0}};

constexpr std::array<std::string_view, 13> prefixes{"a", "f", "p", "n", "\u00b5", "m", "",
                                                    "k", "M", "G", "T", "P",      "E"};

constexpr std::string_view thinSpace = "\u2009";

bool isDigit(char c) {
    return c >= '0' && c <= '9';
}

}  // namespace

int prefixPower(std::string_view unit, double magnitude) {
    if (!(magnitude > 0.0) || !std::isfinite(magnitude)) return 0;
    const auto found = std::find_if(prefixed.begin(), prefixed.end(),
                                    [&](const Prefixed& known) { return known.unit == unit; });
    if (found == prefixed.end()) return 0;
    // A little more, so that what is 1000 but for rounding is 1 of the next.
    const int power = 3 * static_cast<int>(std::floor((std::log10(magnitude) + 1e-9) / 3.0));
    return std::clamp(power, found->least, found->greatest);
}

RichText unitText(std::string_view unit, int power) {
    RichText text;
    if (unit == "1") unit = "";
    std::string run(power == 0 ? "" : prefixes.at(static_cast<std::size_t>(power / 3 + 6)));
    const auto flush = [&](Script script) {
        if (!run.empty()) text.push_back({std::exchange(run, {}), false, script});
    };
    // What is divided by alone has an exponent: m^-1 for 1/m.
    const bool inverse = unit.substr(0, 2) == "1/";
    if (inverse) unit.remove_prefix(2);
    bool raised = false;
    for (std::size_t i = 0; i < unit.size(); ++i) {
        if (unit[i] == '^' || unit.substr(i, 2) == "**") {
            if (unit[i] == '*') ++i;
            flush(Script::normal);
            if (inverse) run += "\u2212";
            while (i + 1 < unit.size() && (isDigit(unit[i + 1]) || unit[i + 1] == '-'))
                run += withMinusSign(unit.substr(++i, 1));
            flush(Script::above);
            raised = true;
        } else if (unit[i] == '*' || unit[i] == ' ') {
            run += thinSpace;
        } else {
            run += unit[i];
        }
    }
    flush(Script::normal);
    if (inverse && !raised) text.push_back({"\u22121", false, Script::above});
    return text;
}

RichText powerOfTen(int exponent) {
    if (exponent == 0) return upright("1");
    if (exponent == 1) return upright("10");
    return {{"10", false, Script::normal}, {withMinusSign(fmt::to_string(exponent)), false, Script::above}};
}

RichText withUnit(RichText name, std::string_view unit, int prefix, int power) {
    RichText inside;
    if (power != prefix) inside = powerOfTen(power - prefix);
    const RichText written = unitText(unit, prefix);
    if (!inside.empty() && !written.empty()) inside = inside + upright(std::string(thinSpace));
    inside = inside + written;
    if (inside.empty()) return name;
    return name + upright(" (") + inside + upright(")");
}

}  // namespace mote::server
