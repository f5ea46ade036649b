// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the fuzzers' inputs hold readers to, and how an input begins. Functions without state.
#pragma once

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <utility>

namespace mote::test {

/// Aborts, which a fuzzer and a test both notice, whatever the build defines, and says where.
inline void require(bool condition, const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
    if (condition) return;
    std::fprintf(stderr, "%s:%d: what is required does not hold\n", file, line);
    std::abort();
}

/// The first line without its end, and what follows it.
inline std::pair<std::string_view, std::string_view> firstLine(std::string_view input) {
    const std::size_t end = std::min(input.find('\n'), input.size());
    return {input.substr(0, end), input.substr(std::min(end + 1, input.size()))};
}

}  // namespace mote::test
