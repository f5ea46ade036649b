// SPDX-License-Identifier: GPL-3.0-or-later
//
// Numbers out of foreign files: from text, or from bytes of either order wherever they lie. Functions without
// state; they take no memory.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>

namespace mote::prep {

static_assert(std::endian::native == std::endian::little,
              "numbers of files are turned into little-endian ones");

/// Reads sizeof(Number) bytes.
template <class Number>
Number loadNumber(const char* from, bool bigEndian) {
    std::array<char, sizeof(Number)> bytes;
    std::memcpy(bytes.data(), from, sizeof(Number));
    if (bigEndian) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<Number>(bytes);
}

/// The whole of `text` as a number, in any form that C, Fortran or Python print: "1.5e-3", "+1.5D-03",
/// "0.123-104" (an exponent of three digits leaves no place for its letter), "NaN", "Infinity". Too great
/// becomes an infinity, too small 0. Nothing where it is no number.
std::optional<double> parseNumber(std::string_view text);

/// The same, where a comma may stand for the decimal point.
std::optional<double> parseNumberWithComma(std::string_view text);

/// An id: digits as they are, so that all of 64 bits survive; else a number that is whole and not negative.
std::optional<std::uint64_t> parseId(std::string_view text);

/// `text` without blanks at its ends.
std::string_view trim(std::string_view text);

/// Splits a line at `separator`, or at runs of blanks where it is ' ' (a single comma among them is a blank
/// too). A field may stand in double quotes. Fills `fields` as far as they go and returns how many the line
/// has.
std::size_t splitFields(std::string_view line, char separator, std::span<std::string_view> fields);

}  // namespace mote::prep
