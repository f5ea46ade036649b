// SPDX-License-Identifier: GPL-3.0-or-later
//
// Turns a frame message and its payload into pixels. The message and the payload come from the network and
// are not trusted: sizes are checked against the message before memory is taken, damage becomes an Error.
// Pure functions, any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::client {

/// Pixels of a picture, RGBA, row 0 on top, without padding.
struct FramePixels {
    std::uint32_t width = 0;   ///< pixels
    std::uint32_t height = 0;  ///< pixels
    /// SRGB8: 4 bytes a pixel, sRGB-encoded; LINEAR_HALF: four little-endian IEEE halves a pixel, linear.
    proto::PixelFormat format = proto::SRGB8;
    std::vector<std::uint8_t> bytes;
};

/// 4 or 8; 0 for a format that we do not know.
std::size_t bytesPerPixel(proto::PixelFormat format);

/// Errors: corrupt (a size out of range, a payload that is not what the message says), unsupported (an
/// encoding or pixel format of a newer server).
Result<FramePixels> decodeFrame(const proto::Frame& message, std::span<const std::uint8_t> payload);

}  // namespace mote::client
