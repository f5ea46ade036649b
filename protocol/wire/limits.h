// SPDX-License-Identifier: GPL-3.0-or-later
//
// What either side may send at most. Checked before memory is taken. Constants.
#pragma once

#include <cstdint>

#include "protocol/scene/view.h"

namespace mote::wire {

/// The most that one frame of the stream may carry, bytes.
struct FrameLimits {
    std::uint32_t message = 0;
    std::uint32_t payload = 0;

    bool operator==(const FrameLimits&) const = default;
};

/// A client's first message: nobody knows yet who speaks.
inline constexpr FrameLimits helloLimits{4U << 10, 0};
/// A client's later messages.
inline constexpr FrameLimits clientLimits{1U << 20, 0};
/// A server's messages: the payload is at most a picture of the greatest view, eight bytes a pixel, and what
/// a codec adds to bytes that it cannot compress.
inline constexpr FrameLimits serverLimits{16U << 20,
                                          static_cast<std::uint32_t>(8 * View::maxPixels + (2U << 20))};

/// Frames that may be on their way to a client, or waiting in it, at a time.
inline constexpr std::uint32_t frameCredits = 2;
/// The same for a client that says what it has received: what is on its way is then measured in bytes, and
/// this only bounds what a client keeps. Half a second of 30 frames a second.
inline constexpr std::uint32_t measuredFrameCredits = 16;

}  // namespace mote::wire
