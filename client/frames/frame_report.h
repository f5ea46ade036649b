// SPDX-License-Identifier: GPL-3.0-or-later
//
// FrameReport: what --json says of a frame, and ReportLines, which says it in the order of the frames. Values
// of the main thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "client/shared/connection.h"
#include "protocol/base/error.h"

namespace mote::client {

/// Puts text on stdout at once. Errors: internal (nobody reads it any more, the disk is full).
Status print(const std::string& text);

/// Times are the server's own, ms, of all views of the frame.
struct FrameReport {
    std::size_t index = 0;
    std::string file;
    std::uint32_t width = 0, height = 0;  ///< pixels
    std::string device;
    std::uint64_t pointsDrawn = 0;
    double planMs = 0.0, renderMs = 0.0, encodeMs = 0.0;
    std::chrono::steady_clock::time_point since = std::chrono::steady_clock::now();  ///< asked for

    void add(const proto::Frame& message);
    /// One JSON object on one line; the total is from asking to now.
    std::string line() const;
};

class ReportLines {
  public:
    /// Where `wanted` is false nothing is said.
    explicit ReportLines(bool wanted) : wanted_(wanted) {}
    /// A frame of this number will be said, or passed over: numbers ascend.
    void expect(std::size_t index);
    /// Errors: internal (stdout).
    Status say(const FrameReport& report);
    Status passOver(std::size_t index);

  private:
    Status flush();

    bool wanted_;
    std::map<std::size_t, std::optional<std::string>> lines_;  // expected ones; "" is passed over
};

/// How far a run is: on stderr if that is a terminal, and as lines of JobProgress on a
/// descriptor for whoever runs it as a job. One thread.
class ProgressBar {
  public:
    /// Shows nothing where `wanted` is false or stderr is no terminal; `descriptor` below 0: no lines.
    ProgressBar(bool wanted, int descriptor);
    ~ProgressBar();
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    /// `done` of `total` frames, and what is done now.
    void show(std::size_t done, std::size_t total, std::string_view phase = "");

  private:
    void draw(std::size_t done, std::size_t total, std::string_view phase);
    void tell(std::size_t done, std::size_t total, std::string_view phase);

    const bool visible_;
    const int descriptor_;
    const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    std::chrono::steady_clock::time_point told_;
    std::size_t first_ = 0;  // frames that were done when it began
    bool shown_ = false;
};

}  // namespace mote::client
