// SPDX-License-Identifier: GPL-3.0-or-later
//
// PythonLiteral: the part of Python's literals that .npy headers are written in: dicts, tuples, lists, texts,
// integers, True, False and None. A value.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace mote::prep {

struct PythonLiteral {
    enum class Kind : std::uint8_t { none, boolean, integer, text, sequence, dict };

    Kind kind = Kind::none;
    bool boolean = false;
    std::uint64_t integer = 0;
    std::string text;
    std::vector<PythonLiteral> items;  ///< of a sequence; of a dict: key, value, key, value, ...

    /// The value of a key in a dict; nullptr where there is none.
    const PythonLiteral* find(std::string_view key) const;

    /// One literal with nothing but blanks around it. Nothing where it is none, is nested deeper than 8 or
    /// has more than 4096 items.
    static std::optional<PythonLiteral> parse(std::string_view source);
};

}  // namespace mote::prep
