// SPDX-License-Identifier: GPL-3.0-or-later
//
// FilmPreview: which time of a film is shown while it is played in real time: that of the frame that is due,
// so that a slow server leaves frames out and never makes it late. A value that knows no clock.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

namespace mote::client {

class FilmPreview {
  public:
    bool loop = true;

    bool playing() const { return playing_; }
    /// At `now` seconds shows the film from `seconds` on; from its begin where that is its end.
    void start(double now, double seconds, double begin, double end) {
        const double from = seconds < end ? std::max(seconds, begin) : begin;
        playing_ = end > begin;
        origin_ = now - (from - begin);
        shown_.reset();
    }
    void stop() { playing_ = false; }

    /// The time of the frame that is due at `now`, where it is another than before. Stops with the last frame
    /// unless it loops.
    std::optional<double> next(double now, double begin, double end, double fps) {
        if (!playing_) return std::nullopt;
        double passed = std::max(now - origin_, 0.0);
        const double length = end - begin;
        if (!(length > 0.0)) {
            stop();
            return std::nullopt;
        }
        if (passed >= length && !loop) {
            stop();
            return end;
        }
        passed = std::fmod(passed, length + 1.0 / fps);  // the last frame is seen as long as the others
        const double due = std::min(begin + std::floor(passed * fps) / fps, end);
        if (shown_ == due) return std::nullopt;
        shown_ = due;
        return due;
    }

  private:
    bool playing_ = false;
    double origin_ = 0.0;          // seconds; when the film began
    std::optional<double> shown_;  // seconds of the film
};

}  // namespace mote::client
