// SPDX-License-Identifier: GPL-3.0-or-later
//
// The units of lengths, times and momenta by the names that tables give them, and how such names are
// compared. Values and functions without state.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "preprocess/readers/field_meaning.h"
#include "protocol/base/utf8.h"
#include "protocol/scene/space/length_unit.h"

namespace mote::prep {

struct Unit {
    std::string_view name;  // lower case, without blanks, '*', '.' and '_'
    double factor;
};

/// Those of length_unit.h, all of which are written so.
inline constexpr auto lengths = [] {
    std::array<Unit, ownLengthUnits.size() + otherLengthUnits.size()> all{};
    auto* next = all.begin();
    for (const auto& unit : ownLengthUnits) *next++ = {unit.name, unit.metres};
    for (const auto& unit : otherLengthUnits) *next++ = {unit.name, unit.metres};
    return all;
}();
inline constexpr Unit times[] = {{"s", 1},     {"sec", 1},          {"ms", 1e-3},        {"us", 1e-6},
                                 {"ns", 1e-9}, {"\xc2\xb5s", 1e-6}, {"\xce\xbcs", 1e-6}, {"ps", 1e-12},
                                 {"fs", 1e-15}};
inline constexpr Unit momenta[] = {{"ev/c", 1},
                                   {"kev/c", 1e3},
                                   {"mev/c", 1e6},
                                   {"gev/c", 1e9},
                                   {"tev/c", 1e12},
                                   {"ev", 1},
                                   {"kev", 1e3},
                                   {"mev", 1e6},
                                   {"gev", 1e9},
                                   {"tev", 1e12},
                                   {"kgm/s", momentumInEv},
                                   {"kgms^-1", momentumInEv}};

/// As the tables of units have it.
inline std::string unitName(std::string_view text) {
    std::string result = lower(text);
    std::erase_if(result, [](char c) { return c == ' ' || c == '*' || c == '.' || c == '_'; });
    return result;
}

}  // namespace mote::prep
