// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

namespace mote::server::log {

void setUp(const char* program) {
    spdlog::set_default_logger(spdlog::stderr_color_mt(program));
    spdlog::set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %v");
}

void write(Level level, std::string_view line) {
    const auto known = level == Level::info      ? spdlog::level::info
                       : level == Level::warning ? spdlog::level::warn
                                                 : spdlog::level::err;
    spdlog::log(known, line);
}

}  // namespace mote::server::log
