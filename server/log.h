// SPDX-License-Identifier: GPL-3.0-or-later
//
// The server's log: what people should know, one line each, as text or as JSON. spdlog writes it and stays
// behind this header, which costs a source that only says something nothing to compile. Any thread.
//
// The format string of a line is its kind: of one kind so many lines a minute are written, then how many more
// there were. Control characters are shown and never written, whoever's text they are in.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <exception>
#include <filesystem>
#include <string_view>
#include <utility>

#include "protocol/base/error.h"

namespace mote::server::log {

struct Settings {
    bool json = false;
    std::filesystem::path file;          ///< empty: stderr
    std::uint64_t fileSize = 16u << 20;  ///< bytes; then the file is put aside
    unsigned oldFiles = 4;               ///< put aside and kept: FILE.1 is the latest
    unsigned linesAMinute = 120;         ///< of one kind
};

/// Lines go there from now on; before, to stderr as text. Errors: permissionDenied (the file).
Status setUp(const Settings& settings);
/// Opens the file anew: in a process that was forked, or where another wrote to it meanwhile, which may have
/// put it aside.
void reopen();
/// Says what was left out so far; before the program ends.
void finish();

/// What a line is about: a field of its own in JSON, its beginning in text.
struct About {
    std::uint64_t session = 0;  ///< 0: none
    std::string_view job;       ///< its id; empty: none
};
inline About session(std::uint64_t id) {
    return {id, {}};
}
inline About job(std::string_view id) {
    return {0, id};
}

/// An error, "WHAT: SENTENCE"; nothing where memory is too short to say it.
void failure(std::string_view what, const std::exception& failure) noexcept;

enum class Level { info, warning, error };
void write(Level level, const About& about, fmt::string_view kind, std::string_view text);

template <class... Values>
void info(const About& about, fmt::format_string<Values...> text, Values&&... values) {
    write(Level::info, about, fmt::string_view(text), fmt::format(text, std::forward<Values>(values)...));
}
template <class... Values>
void info(fmt::format_string<Values...> text, Values&&... values) {
    info(About{}, text, std::forward<Values>(values)...);
}

template <class... Values>
void warn(const About& about, fmt::format_string<Values...> text, Values&&... values) {
    write(Level::warning, about, fmt::string_view(text), fmt::format(text, std::forward<Values>(values)...));
}
template <class... Values>
void warn(fmt::format_string<Values...> text, Values&&... values) {
    warn(About{}, text, std::forward<Values>(values)...);
}

template <class... Values>
void error(const About& about, fmt::format_string<Values...> text, Values&&... values) {
    write(Level::error, about, fmt::string_view(text), fmt::format(text, std::forward<Values>(values)...));
}
template <class... Values>
void error(fmt::format_string<Values...> text, Values&&... values) {
    error(About{}, text, std::forward<Values>(values)...);
}

}  // namespace mote::server::log
