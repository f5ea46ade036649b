// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/quantity_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "protocol/quantity/known_quantity.h"

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

/// A letter and its index: "p_x", "E_kin"; a word stands upright.
RichText symbolText(std::string_view symbol) {
    const auto at = symbol.find('_');
    RichText text = italic(std::string(symbol.substr(0, at)));
    if (at == std::string_view::npos) return text;
    const auto index = symbol.substr(at + 1);
    text.push_back({std::string(index), index.size() == 1, Script::below});
    return text;
}

/// All of a text lowered: the index of a symbol.
RichText lowered(RichText text) {
    for (auto& run : text) run.script = Script::below;
    return text;
}

/// Takes a beginning from a name.
bool take(std::string_view& name, std::string_view beginning) {
    if (name.substr(0, beginning.size()) != beginning) return false;
    name.remove_prefix(beginning.size());
    return true;
}

/// "x", "y", "z", or "4D": of which plane a statistic is.
RichText plane(std::string_view name) {
    if (name == "4d") return upright("4D");
    constexpr std::string_view betatron = "_no_dispersion";
    if (name.size() > betatron.size() && name.substr(name.size() - betatron.size()) == betatron)
        return plane(name.substr(0, name.size() - betatron.size())) + upright(",\u200a\u03b2");
    if (name.size() == 1) return italic(std::string(name));
    return quantityText(name);
}

RichText withIndex(std::string symbol, const RichText& index) {
    return italic(std::move(symbol)) + lowered(index);
}

/// "90" of "90_action_x", which loses it.
std::string takeDigits(std::string_view& name) {
    const auto end = std::find_if_not(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; });
    std::string digits(name.begin(), end);
    name.remove_prefix(digits.size());
    return digits;
}

RichText emittance(std::string_view name, const std::string& before) {
    const std::string digits = takeDigits(name);
    if (digits.empty()) {
        if (!take(name, "_")) return {};
        return withIndex("\u03b5", before.empty() ? plane(name) : upright(before + ",\u200a") + plane(name));
    }
    if (!take(name, "_action_")) return {};
    // Percentiles are normalised, whatever their name says.
    return withIndex("\u03b5", upright("n,\u200a" + digits + "%,\u200a") + plane(name));
}

struct Symbol {
    std::string_view beginning, symbol;
};
constexpr std::array indexedSymbols{Symbol{"sigma_", "\u03c3"},      Symbol{"twiss_alpha_", "\u03b1"},
                                    Symbol{"twiss_beta_", "\u03b2"}, Symbol{"twiss_gamma_", "\u03b3"},
                                    Symbol{"twiss_eta_", "\u03b7"},  Symbol{"twiss_etap_", "\u03b7\u2032"},
                                    Symbol{"halo_h_", "h"},          Symbol{"halo_H_", "H"}};
constexpr std::array words{Symbol{"mean_", "mean\u2009"}, Symbol{"min_", "min\u2009"},
                           Symbol{"max_", "max\u2009"}};

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

RichText quantityText(std::string_view name) {
    const auto* const known = findKnownQuantity(name);
    if (known != nullptr && name != "weight") return symbolText(known->symbol);
    return name.size() == 1 ? italic(std::string(name)) : upright(std::string(name));
}

RichText statisticText(std::string_view name) {
    std::string_view left = name;
    RichText text;
    if (take(left, "norm_emit"))
        text = emittance(left, "n");
    else if (take(left, "emit"))
        text = emittance(left, "");
    if (!text.empty()) return text;
    left = name;
    for (const auto& [beginning, symbol] : indexedSymbols) {
        if (take(left, beginning)) return withIndex(std::string(symbol), plane(left));
    }
    for (const auto& [beginning, word] : words) {
        if (take(left, beginning)) return upright(std::string(word)) + quantityText(left);
    }
    if (take(left, "cov_")) {
        const auto gap = left.find("__");
        if (gap != std::string_view::npos) {
            return upright("cov(") + quantityText(left.substr(0, gap)) + upright(",\u2009") +
                   quantityText(left.substr(gap + 2)) + upright(")");
        }
    }
    if (name == "charge") return italic("Q");
    if (name == "n_particle") return upright("particles");
    if (name == "n_lost") return upright("lost particles");
    return quantityText(name);
}

}  // namespace mote::server
