// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/wire/framing.h"

#include <fmt/format.h>

#include <algorithm>

namespace mote::wire {
namespace {

constexpr std::array<std::uint8_t, 4> magic{'M', 'O', 'T', 'E'};

template <class Integer>
void put(std::uint8_t* to, Integer value) {
    for (std::size_t i = 0; i < sizeof(Integer); ++i) to[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

template <class Integer>
Integer get(const std::uint8_t* from) {
    Integer value = 0;
    for (std::size_t i = 0; i < sizeof(Integer); ++i) value |= static_cast<Integer>(from[i]) << (8 * i);
    return value;
}

Status checkLength(const char* part, std::uint64_t length, std::uint32_t limit) {
    if (length <= limit) return success();
    return Error{ErrorCode::resourceExhausted, part,
                 fmt::format("{} bytes are more than the {} that are allowed here", length, limit)};
}

Status checkLengths(std::uint64_t message, std::uint64_t payload, FrameLimits limits) {
    MOTE_RETURN_IF_ERROR(checkLength("message", message, limits.message));
    return checkLength("payload", payload, limits.payload);
}

}  // namespace

Greeting encodeGreeting(Version version) {
    Greeting bytes{};
    std::copy(magic.begin(), magic.end(), bytes.begin());
    put(bytes.data() + 4, version.major);
    put(bytes.data() + 6, version.minor);
    return bytes;
}

Result<Version> decodeGreeting(const Greeting& bytes, Version own) {
    if (!std::equal(magic.begin(), magic.end(), bytes.begin())) {
        return Error{ErrorCode::corrupt, "greeting", "the other side does not speak Mote's protocol"};
    }
    const Version version{get<std::uint16_t>(bytes.data() + 4), get<std::uint16_t>(bytes.data() + 6)};
    if (version.major == own.major) return version;
    return Error{ErrorCode::unsupported, "greeting",
                 fmt::format("the other side speaks protocol version {}.{}, this one {}.{}; use programs of "
                             "the same major version",
                             version.major, version.minor, own.major, own.minor)};
}

Result<Header> encodeHeader(FrameHeader header, FrameLimits limits) {
    MOTE_RETURN_IF_ERROR(checkLengths(header.message, header.payload, limits));
    Header bytes{};
    put(bytes.data(), header.message);
    put(bytes.data() + 4, header.payload);
    return bytes;
}

Result<FrameHeader> decodeHeader(const Header& bytes, FrameLimits limits) {
    const FrameHeader header{get<std::uint32_t>(bytes.data()), get<std::uint32_t>(bytes.data() + 4)};
    MOTE_RETURN_IF_ERROR(checkLengths(header.message, header.payload, limits));
    return header;
}

Status encodeFrame(const google::protobuf::MessageLite& message, std::size_t payloadSize, FrameLimits limits,
                   std::vector<std::uint8_t>& bytes) {
    const std::size_t size = message.ByteSizeLong();
    MOTE_RETURN_IF_ERROR(checkLengths(size, payloadSize, limits));
    MOTE_ASSIGN_OR_RETURN(
        const auto header,
        encodeHeader({static_cast<std::uint32_t>(size), static_cast<std::uint32_t>(payloadSize)}, limits));
    bytes.resize(header.size() + size);
    std::copy(header.begin(), header.end(), bytes.begin());
    MOTE_CHECK(message.SerializeToArray(bytes.data() + header.size(), static_cast<int>(size)));
    return success();
}

Status decodeMessage(std::span<const std::uint8_t> bytes, google::protobuf::MessageLite& message) {
    // Proto3 demands that strings are UTF-8: the parser refuses others, and how deep messages may nest.
    if (bytes.size() <= INT32_MAX && message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
        return success();
    }
    return Error{ErrorCode::corrupt, "message",
                 fmt::format("{} bytes that should be a message of Mote's protocol are none", bytes.size())};
}

}  // namespace mote::wire
