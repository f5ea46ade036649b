// SPDX-License-Identifier: GPL-3.0-or-later
//
// The symbols that papers print for columns, derived quantities and statistics: p with an index x for "px", δ
// for "delta", ε for "emit_x". Pure functions; a name that is not known stands as it is.
#pragma once

#include <string>
#include <string_view>

#include "server/figures/rich_text.h"

namespace mote::server {

/// Of a column or derived quantity.
RichText quantityText(std::string_view name);
/// Of a statistic (docs/NUMBERS.md).
RichText statisticText(std::string_view name);

}  // namespace mote::server
