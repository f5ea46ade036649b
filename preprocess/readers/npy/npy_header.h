// SPDX-License-Identifier: GPL-3.0-or-later
//
// NpyHeader: the header of a NumPy .npy file, a literal of Python in which the element's type and the array's
// shape stand. Parsed from bytes that nobody vouches for. Values and functions without state.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"

namespace mote::prep {

/// The part of Python's literals that .npy headers are written in: dicts, tuples, lists,
/// texts, integers, True, False and None.
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

/// One number in a row.
struct NpyField {
    std::string name;  ///< "" where the type has no fields
    static constexpr char other = 'x';
    char kind = 'f';        ///< 'f', 'i', 'u' (booleans are 'u' of one byte) or other: no number that is read
    std::size_t bytes = 8;  ///< of one number: 1 (integers only), 2, 4 or 8
    bool bigEndian = false;
    std::size_t count = 1;   ///< numbers in a row: more than 1 for a sub-array
    std::size_t offset = 0;  ///< bytes, in a row
};

struct NpyHeader {
    std::vector<NpyField> fields;  ///< one without a name for a plain array
    std::size_t itemBytes = 0;     ///< of an element
    std::vector<std::uint64_t> shape;
    bool fortranOrder = false;
    std::uint64_t dataOffset = 0;  ///< bytes, in the file

    bool structured() const { return fields.size() != 1 || !fields[0].name.empty(); }

    /// How many bytes of a file's beginning parse() may need: at most 1 MiB.
    static constexpr std::size_t maxBytes = (1u << 20) + 12;

    /// How many bytes of a file's beginning its header takes, as its first 12 bytes say; at most maxBytes.
    static std::size_t bytesNeeded(std::span<const char> begin);

    /// `bytes` is the beginning of the file. Errors, at `where`: corrupt, unsupported (Python objects, nested
    /// fields).
    static Result<NpyHeader> parse(std::span<const char> bytes, const std::string& where);
};

}  // namespace mote::prep
