// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/playback.h"

namespace mote::client {

std::optional<std::uint32_t> Playback::next(double now, std::uint32_t step, int steps, bool seen) {
    if (!playing || !seen || steps < 2 || now < last_ + 1.0 / stepsPerSecond) return std::nullopt;
    last_ = now;
    return (step + 1) % static_cast<std::uint32_t>(steps);
}

}  // namespace mote::client
