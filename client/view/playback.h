// SPDX-License-Identifier: GPL-3.0-or-later
//
// Playback: when the next step of a series is shown: at a chosen rate, but not before the one of now was
// seen, so that a slow server leaves none out. A value that knows no clock.
#pragma once

#include <cstdint>
#include <optional>

namespace mote::client {

class Playback {
  public:
    bool playing = false;
    float stepsPerSecond = 10.0F;

    /// The step to show at `now` seconds; after the last comes the first. `seen`: a picture of `step` is on
    /// the screen.
    std::optional<std::uint32_t> next(double now, std::uint32_t step, int steps, bool seen) {
        if (!playing || !seen || steps < 2 || now < last_ + 1.0 / stepsPerSecond) return std::nullopt;
        last_ = now;
        return (step + 1) % static_cast<std::uint32_t>(steps);
    }

  private:
    double last_ = 0.0;  // seconds; when a step was last shown
};

}  // namespace mote::client
