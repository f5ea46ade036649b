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

#include "protocol/scene/error.h"
#include "protocol/wire/limits.h"

namespace mote::wire {

/// Sides of the same major version understand each other; a minor version only adds.
struct Version {
    std::uint16_t major = 0;
    std::uint16_t minor = 0;

    bool operator==(const Version&) const = default;
};

/// What this build speaks.
inline constexpr Version ownVersion{1, 1};

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
