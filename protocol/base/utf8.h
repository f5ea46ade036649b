// SPDX-License-Identifier: GPL-3.0-or-later
//
// Text in messages is UTF-8, file names are bytes, and a log has lines. Pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace mote {

/// How many bytes the character at the beginning of a text takes, which is not empty; 0 where there is none
/// (Unicode 15, table 3-7).
std::size_t characterLength(std::string_view text);

/// Whether all of it is UTF-8 as Unicode defines it: no overlong forms, no surrogates.
bool isUtf8(std::string_view text);

/// Each byte that belongs to no character becomes "?".
std::string toUtf8(std::string_view text);

/// Whether a character is one that a terminal would obey, and not show: C0, DEL and C1 (U+0080 to U+009F).
bool isControl(std::string_view character);

/// Makes text of others fit for a terminal, on one line: control characters are shown as "\xNN", bytes that
/// belong to no character as "?".
std::string toTerminalText(std::string_view text);
/// The same, but newlines and tabs stay.
std::string toTerminalLines(std::string_view text);

/// Makes the letters A to Z small, and nothing else.
std::string lower(std::string_view text);

/// Makes text fit for a line of the log: as toUtf8, control characters "?" too, so that no text of a client
/// looks like a line of ours, and cut to 500 bytes.
std::string toLogText(std::string_view text);

}  // namespace mote
