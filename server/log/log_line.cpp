// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/log/log_line.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "protocol/base/json_string.h"
#include "protocol/base/utf8.h"

namespace mote::server::log {
namespace {

std::string_view nameOf(Level level) {
    if (level == Level::error) return "error";
    return level == Level::warning ? "warning" : "info";
}

/// In UTC, by RFC 3339.
std::string timeOf(std::chrono::system_clock::time_point time) {
    const auto ms = std::chrono::time_point_cast<std::chrono::milliseconds>(time);
    return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(std::chrono::system_clock::to_time_t(time)),
                       ms.time_since_epoch().count() % 1000);
}

}  // namespace

std::string toText(const Line& line) {
    std::string text = fmt::format("{} {} ", timeOf(line.time), nameOf(line.level));
    if (line.about.session != 0) text += fmt::format("session {}: ", line.about.session);
    if (!line.about.job.empty()) text += fmt::format("job {}: ", toTerminalText(line.about.job));
    return text + toTerminalText(line.text);
}

std::string toJson(const Line& line) {
    std::string text =
        fmt::format("{{\"time\": \"{}\", \"level\": \"{}\"", timeOf(line.time), nameOf(line.level));
    if (line.about.session != 0) text += fmt::format(", \"session\": {}", line.about.session);
    if (!line.about.job.empty()) text += fmt::format(", \"job\": {}", jsonString(line.about.job));
    return text + fmt::format(", \"kind\": {}, \"text\": {}}}", jsonString(line.kind), jsonString(line.text));
}

}  // namespace mote::server::log
