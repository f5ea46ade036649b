// SPDX-License-Identifier: GPL-3.0-or-later
//
// The symbols that papers print for columns, derived quantities and statistics: p with an index x for "px", δ
// for "delta", ε for "emit_x"; a name that is not known stands as it is. And units, with SI prefixes if a
// unit takes them. Pure functions.
#pragma once

#include <string>
#include <string_view>

#include "server/figures/rich_text.h"

namespace mote::server {

/// The power of ten of the prefix that suits a unit for values up to a magnitude: -3 for 0.02 m; a multiple
/// of 3, 0 if the unit takes no prefix that would do ("1", "1/m", "s" above its own).
int prefixPower(std::string_view unit, double magnitude);

/// "keV/c" with a power of 3. `power`: one that prefixPower() gave. "1" and "" are nothing.
RichText unitText(std::string_view unit, int power);

/// 10 with an exponent: "10^−3"; "1" and "10" for the first two.
RichText powerOfTen(int exponent);

/// What an axis says: "name (keV/c)", "name (10^−3)", "name" alone. `power`: what a label's number is
/// multiplied with to be in the unit, of which the prefix takes `prefix`.
RichText withUnit(RichText name, std::string_view unit, int prefix, int power);

/// Of a column or derived quantity.
RichText quantityText(std::string_view name);
/// Of a statistic (docs/NUMBERS.md).
RichText statisticText(std::string_view name);

}  // namespace mote::server
