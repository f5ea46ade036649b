// SPDX-License-Identifier: GPL-3.0-or-later
//
// What mote-prep says to whoever started it, and hears: progress as a bar on a terminal or as JSON lines on a
// descriptor, results as JSON objects, signals. Owned by main.
#pragma once

#include <concepts>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/job.h"

namespace mote::prep {

/// One flat JSON object, member by member, for --json. (Not protobuf's Struct: its maps have
/// another layout under the thread sanitizer than in the library.)
class JsonObject {
  public:
    JsonObject& add(std::string_view name, std::string_view text);
    JsonObject& add(std::string_view name, const char* text) { return add(name, std::string_view(text)); }
    JsonObject& add(std::string_view name, bool value);
    JsonObject& add(std::string_view name, double number);
    template <std::integral Number>
    requires(!std::same_as<Number, bool>) JsonObject& add(std::string_view name, Number number) {
        return addRaw(name, std::to_string(number));
    }
    JsonObject& add(std::string_view name, const std::vector<JsonObject>& objects);

    /// One line, without a newline.
    std::string text() const { return "{" + members_ + "}"; }

  private:
    JsonObject& addRaw(std::string_view name, std::string_view json);

    std::string members_;
};

/// SIGINT and SIGTERM ask the job to stop instead of ending the process, so that it can remove
/// what it has begun. One object in a program, made in main before any thread.
class CancelSignal {
  public:
    /// Takes SIGINT and SIGTERM; ignores SIGPIPE and SIGXFSZ, which become errors of the write. A second
    /// signal of the same kind ends the process at once.
    CancelSignal();

    /// The signal that came, or 0.
    int received() const;
};

/// A job's progress as a bar on a terminal, or as one JSON line a change (proto::JobProgress) on a descriptor
/// for the program that started the job. Notes go to stderr. Any thread may report.
class ConsoleProgress final : public Progress {
  public:
    struct Options {
        bool quiet = false;       ///< neither bar nor notes
        int lineDescriptor = -1;  ///< where JSON lines go; -1: nowhere
    };

    ConsoleProgress(const CancelSignal& signal, Options options);
    /// Takes the bar away.
    ~ConsoleProgress() override;

    void report(double fraction, std::string_view phase) override;
    void note(std::string_view sentence) override;
    bool cancelled() const override { return signal_.received() != 0; }

  private:
    void writeLine();
    void drawBar() const;
    void clearBar() const;

    const CancelSignal& signal_;
    Options options_;
    bool bar_;  ///< stderr is a terminal and wanted
    std::mutex mutex_;
    double fraction_ = 0.0;
    int percent_ = -1;
    std::string phase_;
};

}  // namespace mote::prep
