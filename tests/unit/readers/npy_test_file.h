// SPDX-License-Identifier: GPL-3.0-or-later
//
// Writes .npy files for the tests, byte by byte. Functions without state.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/random.h"

namespace mote::test {

/// A file with this header, whatever it says.
inline std::string npy(std::string dict, std::string_view data, int version = 1) {
    const std::size_t prefix = version == 1 ? 10 : 12;
    while ((prefix + dict.size() + 1) % 64 != 0) dict += ' ';
    dict += '\n';
    std::string bytes = "\x93NUMPY";
    bytes += {static_cast<char>(version), 0};
    for (int i = 0; i < (version == 1 ? 2 : 4); ++i) bytes += static_cast<char>(dict.size() >> (8 * i));
    return bytes + dict + std::string(data);
}

template <class Number>
std::string packed(std::span<const double> values, bool bigEndian = false) {
    std::string bytes;
    for (const double value : values) {
        const auto number = static_cast<Number>(value);
        std::string one(reinterpret_cast<const char*>(&number), sizeof(number));
        if (bigEndian) std::reverse(one.begin(), one.end());
        bytes += one;
    }
    return bytes;
}

template <class Number>
std::string packed(std::initializer_list<double> values, bool bigEndian = false) {
    return packed<Number>(std::span(values.begin(), values.size()), bigEndian);
}

/// An array of doubles: "(3,)", "(2, 3)".
inline std::string doubles(const std::string& shape, const std::vector<double>& values) {
    return npy("{'descr': '<f8', 'fortran_order': False, 'shape': " + shape + ", }", packed<double>(values));
}

inline std::vector<double> randomValues(Random& random, std::size_t count) {
    std::vector<double> values(count);
    for (double& value : values) value = random.between(-1e3, 1e3);
    return values;
}

}  // namespace mote::test
