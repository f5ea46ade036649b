// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

namespace mote::server::log {
namespace {

spdlog::level::level_enum levelOf(Level level) {
    switch (level) {
        case Level::info:
            return spdlog::level::info;
        case Level::warning:
            return spdlog::level::warn;
        case Level::error:
            break;
    }
    return spdlog::level::err;
}

}  // namespace

void setUp(const char* program) {
    spdlog::set_default_logger(spdlog::stderr_color_mt(program));
    spdlog::set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %v");
}

void write(Level level, std::string_view line) {
    spdlog::log(levelOf(level), line);
}

}  // namespace mote::server::log
