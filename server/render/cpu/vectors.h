// SPDX-License-Identifier: GPL-3.0-or-later
//
// The kinds of vectors that the cpu device is compiled for and that this processor has: all draw the same
// picture (docs/PICTURE.md, "Any processor"), the widest one fastest. The environment variable MOTE_VECTORS
// allows one alone, so that what happened elsewhere can be seen here. The choice is the process's; change it
// only while no device draws.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace mote::render {

/// The kind that is drawn with now: "AVX-512", "AVX2", "SSE4", "SSSE3" or "SCALAR" (plain numbers).
std::string vectorName();

/// The names of all that there are here, widest first.
std::vector<std::string> vectorNames();

/// Highway's number of the kind with that name, in any case; nothing where it is not here.
std::optional<std::int64_t> vectorsNamed(const std::string& name);

/// Draws with one kind alone; 0: with the widest.
void useVectors(std::int64_t target);

/// Draws with what MOTE_VECTORS names, or with the widest. Throws DeviceError where there is no such kind
/// here.
void useVectorsOfEnvironment();

/// The same, where nobody has chosen yet.
void chooseVectors();

}  // namespace mote::render
