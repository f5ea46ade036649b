// SPDX-License-Identifier: GPL-3.0-or-later
//
// Compressed files for tests of readers. Functions without state.
#pragma once

#include <string>

namespace mote::test {

std::string gzipped(const std::string& bytes);       ///< RFC 1952
std::string zlibDeflated(const std::string& bytes);  ///< RFC 1950

}  // namespace mote::test
