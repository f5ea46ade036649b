// SPDX-License-Identifier: GPL-3.0-or-later
//
// One line of the log as text or JSON, without its newline. Pure functions.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "server/log.h"

namespace mote::server::log {

struct Line {
    std::chrono::system_clock::time_point time;
    Level level = Level::info;
    About about;
    std::string_view kind;  ///< the format string of `text`
    std::string_view text;
};

/// "2026-11-24T04:00:00.123Z warning session 7: closed: ..."
std::string toText(const Line& line);
/// {"time": ..., "level": ..., "session": 7, "kind": "closed: {}", "text": "closed: ..."}
std::string toJson(const Line& line);

}  // namespace mote::server::log
