// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/log.h"

#include <spdlog/sinks/rotating_file_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>

#include <mutex>

#include "protocol/base/mote_check.h"
#include "server/log/line_limit.h"
#include "server/log/log_line.h"

namespace mote::server::log {
namespace {

spdlog::level::level_enum levelOf(Level level) {
    if (level == Level::error) return spdlog::level::err;
    return level == Level::warning ? spdlog::level::warn : spdlog::level::info;
}

spdlog::sink_ptr sinkOf(const Settings& settings) {
    if (settings.file.empty()) return std::make_shared<spdlog::sinks::stderr_sink_mt>();
    spdlog::file_event_handlers handlers;
    // Names of clients and folders are nobody else's.
    handlers.after_open = [](const auto&, std::FILE* file) { ::fchmod(::fileno(file), 0600); };
    return std::make_shared<spdlog::sinks::rotating_file_sink_mt>(settings.file.string(), settings.fileSize,
                                                                  settings.oldFiles, false, handlers);
}

/// The one log of a process.
class Writer {
  public:
    static Writer& instance() {
        static Writer writer;
        return writer;
    }

    Status setUp(const Settings& settings) {
        const std::lock_guard lock(mutex_);
        limit_ = LineLimit(settings.linesAMinute, std::chrono::minutes(1));
        settings_ = settings;
        return open();
    }

    /// Where it cannot be opened any more, lines go where they went.
    void reopen() {
        const std::lock_guard lock(mutex_);
        const auto opened = open();
        if (!opened.ok()) put(Level::error, {}, "{}", opened.error().toString());
    }

    void write(Level level, const About& about, std::string_view kind, std::string_view text) {
        const auto now = LineLimit::Clock::now();
        const std::lock_guard lock(mutex_);
        sayLeftOut(now);
        if (limit_.admit(kind, now)) put(level, about, kind, text);
    }

    void finish() {
        const std::lock_guard lock(mutex_);
        sayLeftOut(LineLimit::Clock::time_point::max());
    }

  private:
    Writer() { MOTE_CHECK(open().ok()); }  // stderr needs no opening

    Status open() {
        try {
            auto logger = std::make_shared<spdlog::logger>("mote", sinkOf(settings_));
            logger->set_pattern("%v");
            logger->flush_on(spdlog::level::trace);
            logger_ = std::move(logger);
            return success();
        } catch (const spdlog::spdlog_ex& failure) {
            return Error{ErrorCode::permissionDenied, "--log", failure.what()};
        }
    }

    void sayLeftOut(LineLimit::Clock::time_point now) {
        for (const auto& left : limit_.over(now)) {
            put(Level::warning, {}, "{} more of: {}", fmt::format("{} more of: {}", left.count, left.kind));
        }
    }

    void put(Level level, const About& about, std::string_view kind, std::string_view text) {
        const Line line{std::chrono::system_clock::now(), level, about, kind, text};
        logger_->log(levelOf(level), settings_.json ? toJson(line) : toText(line));
    }

    std::mutex mutex_;
    Settings settings_;
    LineLimit limit_{settings_.linesAMinute, std::chrono::minutes(1)};
    std::shared_ptr<spdlog::logger> logger_;
};

}  // namespace

Status setUp(const Settings& settings) {
    return Writer::instance().setUp(settings);
}

void reopen() {
    Writer::instance().reopen();
}

void finish() {
    Writer::instance().finish();
}

void failure(std::string_view what, const std::exception& failure) noexcept {
    try {
        error("{}: {}", what, failure.what());
    } catch (const std::exception&) {
        // That it is said is worth less than what goes on.
    }
}

void write(Level level, const About& about, fmt::string_view kind, std::string_view text) {
    Writer::instance().write(level, about, {kind.data(), kind.size()}, text);
}

}  // namespace mote::server::log
