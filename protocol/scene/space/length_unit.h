// SPDX-License-Identifier: GPL-3.0-or-later
//
// Units of lengths: the one table of their names and of what they are in metres, for all who read, say,
// compare or draw lengths. Those at its beginning are Mote's own names, which manifests have and requests
// take; the others are what files call them. Pure functions.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/mote.pb.h"

namespace mote {

struct LengthUnit {
    std::string_view name;
    double metres;
};

inline constexpr std::array<LengthUnit, 10> ownLengthUnits{{{"fm", 1e-15},
                                                            {"pm", 1e-12},
                                                            {"angstrom", 1e-10},
                                                            {"nm", 1e-9},
                                                            {"um", 1e-6},
                                                            {"mm", 1e-3},
                                                            {"cm", 1e-2},
                                                            {"dm", 1e-1},
                                                            {"m", 1.0},
                                                            {"km", 1e3}}};

inline constexpr std::array<LengthUnit, 24> otherLengthUnits{
    {{"\xc2\xb5m", 1e-6},  {"\xce\xbcm", 1e-6},   {"\xb5m", 1e-6},      {"\\u00B5m", 1e-6},
     {"\\u03BCm", 1e-6},   {"micron", 1e-6},      {"microns", 1e-6},    {"micrometer", 1e-6},
     {"micrometre", 1e-6}, {"\xc3\x85", 1e-10},   {"nanometer", 1e-9},  {"nanometre", 1e-9},
     {"millimeter", 1e-3}, {"millimeters", 1e-3}, {"millimetre", 1e-3}, {"centimeter", 1e-2},
     {"centimetre", 1e-2}, {"meter", 1.0},        {"meters", 1.0},      {"metre", 1.0},
     {"kilometer", 1e3},   {"kilometre", 1e3},    {"inch", 25.4e-3},    {"in", 25.4e-3}}};

/// What a length of 1 is in metres; nothing of what is no known unit, of "" too.
std::optional<double> metresOf(std::string_view unit);

/// The name of our own for the same length, else the unit as it is: "um" of "micron".
std::string ownName(std::string_view unit);

/// "fm, pm, ..., m, km", for messages.
std::string lengthUnitNames();

/// Of a length in the world in which a volume, a mesh or a stippled surface lies; "": not known.
const std::string& worldUnit(const proto::Manifest& manifest);

}  // namespace mote
