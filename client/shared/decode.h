// SPDX-License-Identifier: GPL-3.0-or-later
//
// Turns a frame message and its payload into pixels. The message and the payload come from the network and
// are not trusted: sizes are checked against the message before memory is taken, damage becomes an Error.
// Pure functions, any thread; a FrameDecoder has one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::client {

/// The pixels of a decoded frame, RGBA, row 0 on top, without padding. A value.
struct FramePixels {
    std::uint32_t width = 0;   ///< pixels
    std::uint32_t height = 0;  ///< pixels
    /// PIXEL_FORMAT_UNSPECIFIED: no pixels, but the bytes of a document.
    /// SRGB8: 4 bytes a pixel, sRGB-encoded; LINEAR_HALF: four little-endian IEEE halves a pixel, linear.
    proto::PixelFormat format = proto::SRGB8;
    std::vector<std::uint8_t> bytes;
};

/// The H.264 frames of one connection, one after the other, by libavcodec where it is installed. One owner,
/// one thread at a time.
class H264Decoder {
  public:
    H264Decoder();
    ~H264Decoder();
    H264Decoder(const H264Decoder&) = delete;
    H264Decoder& operator=(const H264Decoder&) = delete;

    /// Tells whether libavcodec is on this machine and has a decoder.
    static bool available();

    /// Decodes a picture of a size that has been checked. After an error nothing is decoded up to the next
    /// key frame. Errors: corrupt (damage, or another size than the message says), cancelled (it needs a
    /// frame that was not decoded), unsupported (no decoder here), resourceExhausted.
    Result<FramePixels> decode(std::uint32_t width, std::uint32_t height, bool key,
                               std::span<const std::uint8_t> payload);

  private:
    struct Stream;
    std::unique_ptr<Stream> stream_;  ///< none: a key frame must come first
};

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
