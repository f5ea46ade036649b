// SPDX-License-Identifier: GPL-3.0-or-later
//
// Turns a frame message and its payload into pixels. The message and the payload come from the network and
// are not trusted: sizes are checked against the message before memory is taken, damage becomes an Error.
// Pure functions, any thread; a FrameDecoder has one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "client/shared/frame_pixels.h"
#include "client/shared/h264_decoder.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::client {

/// 4 or 8; 0 for a format that we do not know.
std::size_t bytesPerPixel(proto::PixelFormat format);

/// Errors: corrupt (a size out of range, a payload that is not what the message says), unsupported (an
/// encoding or pixel format of a newer server, or one that needs earlier frames).
Result<FramePixels> decodeFrame(const proto::Frame& message, std::span<const std::uint8_t> payload);

/// The frames of one connection, in their order: also those that need earlier ones.
class FrameDecoder {
  public:
    /// Errors: as of decodeFrame; cancelled: a frame before it was damaged, and it is of no use without.
    Result<FramePixels> decode(const proto::Frame& message, std::span<const std::uint8_t> payload);
    /// The latest H264 frame was not decoded: a key frame must be asked for.
    bool wantsKey() const { return wantsKey_; }

  private:
    H264Decoder h264_;
    bool wantsKey_ = false;
};

}  // namespace mote::client
