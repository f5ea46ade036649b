// SPDX-License-Identifier: GPL-3.0-or-later
//
// The server's log, on stderr: what people should know, one line each. spdlog writes it and stays behind this
// header, which costs a source that only says something nothing to compile. Any thread.
#pragma once

#include <fmt/format.h>

#include <string_view>
#include <utility>

namespace mote::server::log {

/// Lines with a time and a level, under the program's name. Until then spdlog's own way of writing is used.
void setUp(const char* program);

enum class Level { info, warning, error };
void write(Level level, std::string_view line);

template <class... Values>
void info(fmt::format_string<Values...> text, Values&&... values) {
    write(Level::info, fmt::format(text, std::forward<Values>(values)...));
}

template <class... Values>
void warn(fmt::format_string<Values...> text, Values&&... values) {
    write(Level::warning, fmt::format(text, std::forward<Values>(values)...));
}

template <class... Values>
void error(fmt::format_string<Values...> text, Values&&... values) {
    write(Level::error, fmt::format(text, std::forward<Values>(values)...));
}

}  // namespace mote::server::log
