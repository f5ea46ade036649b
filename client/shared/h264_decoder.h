// SPDX-License-Identifier: GPL-3.0-or-later
//
// H264Decoder: the H.264 frames of one connection, one after the other. The payloads come from the network
// and are not trusted. One owner, one thread at a time; the only place of the client that knows libavcodec.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "client/shared/frame_pixels.h"
#include "protocol/scene/error.h"

namespace mote::client {

class H264Decoder {
  public:
    H264Decoder();
    ~H264Decoder();
    H264Decoder(const H264Decoder&) = delete;
    H264Decoder& operator=(const H264Decoder&) = delete;

    /// Whether libavcodec has a decoder on this machine.
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

}  // namespace mote::client
