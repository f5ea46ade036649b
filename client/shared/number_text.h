// SPDX-License-Identifier: GPL-3.0-or-later
//
// Numbers and names as files and terminals have them. Pure functions.
#pragma once

#include <string>
#include <string_view>

namespace mote::client {

/// As few digits as give the same double again; `undefined` where it is not finite.
std::string exactNumber(double value, std::string_view undefined);

/// A field of a line of comma-separated values (RFC 4180).
std::string csvField(std::string_view text);

/// A number for people, in a prefix of its unit.
struct ScaledUnit {
    double scale = 1.0;  ///< of one scaled unit, in the unit
    std::string name;    ///< "mm"
};

/// The unit with the SI prefix in which `magnitude` is 1 to 1000. Units that are no plain ones (m^2, 1/m, 1)
/// have no prefix, and neither has what is zero or not finite.
ScaledUnit scaledUnit(double magnitude, std::string_view unit);

/// Of a value in that unit, five digits; "-" where it is not finite.
std::string shortNumber(double value, const ScaledUnit& unit);

/// How many columns of a terminal a text takes that is of letters alone.
std::size_t widthOf(std::string_view text);
/// The text with blanks before or behind it until it is that wide.
std::string padLeft(std::string_view text, std::size_t width);
std::string padRight(std::string_view text, std::size_t width);

}  // namespace mote::client
