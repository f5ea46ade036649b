// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which names somebody may have meant. A pure function.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace mote {

/// "; near it: energy, E" of at most three names that differ in letter case, one begins with the other, or
/// by two letters at most, the nearest first, each once; "" where there is none.
std::string nearNames(std::string_view name, std::span<const std::string_view> all);

}  // namespace mote
