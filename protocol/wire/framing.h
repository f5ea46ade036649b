// SPDX-License-Identifier: GPL-3.0-or-later
//
// Framing: how messages lie in the byte stream. Both sides first send a greeting, `MOTE`, u16 major, u16
// minor; then come frames of u32 message length, u32 payload length, the protobuf message, the payload. All
// integers are little-endian. Pure functions over bytes, free of Asio, any thread.
#pragma once

#include <google/protobuf/message_lite.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/scene/view.h"

namespace mote::wire {

/// The most that one frame of the stream may carry, bytes. Checked before memory is taken.
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
/// Views of one client that may wait to be drawn in their turn, that under way included.
inline constexpr std::uint32_t maxQueuedViews = 16;

/// Sides of the same major version understand each other; a minor version only adds.
struct Version {
    std::uint16_t major = 0;
    std::uint16_t minor = 0;

    bool operator==(const Version&) const = default;
};

/// What this build speaks.
inline constexpr Version ownVersion{1, 5};
/// Clients of this minor version and above answer a server's pings.
inline constexpr std::uint32_t pingsFromMinor = 3;

using Greeting = std::array<std::uint8_t, 8>;
using Header = std::array<std::uint8_t, 8>;

/// The lengths of one frame's parts, bytes.
struct FrameHeader {
    std::uint32_t message = 0;
    std::uint32_t payload = 0;

    bool operator==(const FrameHeader&) const = default;
};

Greeting encodeGreeting(Version version);

/// The version of the other side. Errors: corrupt (not our protocol at all), unsupported (another major
/// version than `own`).
Result<Version> decodeGreeting(const Greeting& bytes, Version own = ownVersion);

/// Errors: resourceExhausted where a part is longer than the other side takes: nothing must be sent then.
Result<Header> encodeHeader(FrameHeader header, FrameLimits limits);

/// Errors: resourceExhausted where a part is longer than we take: nothing must be allocated then.
Result<FrameHeader> decodeHeader(const Header& bytes, FrameLimits limits);

/// Replaces `bytes` (which keep their capacity) by the header and the message of a frame; the payload follows
/// them on the wire without being copied. Errors: resourceExhausted, `bytes` are then as they were.
Status encodeFrame(const google::protobuf::MessageLite& message, std::size_t payloadSize, FrameLimits limits,
                   std::vector<std::uint8_t>& bytes);

/// Replaces `message`. Errors: corrupt where the bytes are no such message.
Status decodeMessage(std::span<const std::uint8_t> bytes, google::protobuf::MessageLite& message);

}  // namespace mote::wire
