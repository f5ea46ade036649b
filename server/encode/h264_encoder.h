// SPDX-License-Identifier: GPL-3.0-or-later
//
// H264Encoder: pictures become a stream of H.264 in which a picture is decoded as soon as it is there (x264,
// ultrafast, zero latency) and none is larger than the link's share. Colours: protocol/wire/ycc.h. One owner,
// one thread at a time; the only place of the server that knows libavcodec.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "protocol/scene/error.h"
#include "server/render/plan/picture.h"

namespace mote::server {

struct H264Picture {
    std::vector<std::uint8_t> payload;  ///< Annex B
    bool key = false;                   ///< needs none before it
};

class H264Encoder {
  public:
    /// Below this a picture shows nothing any more; bytes.
    static constexpr std::size_t leastBytes = 4096;

    H264Encoder();
    ~H264Encoder();
    H264Encoder(const H264Encoder&) = delete;
    H264Encoder& operator=(const H264Encoder&) = delete;

    /// Encodes an srgb8 picture (our own invariant), in about `mostBytes` at most (a difficult picture may
    /// take a tenth more). A new size, or `key`, begins the stream anew. Errors: unsupported (no such encoder
    /// here, or the picture is too large for it), internal, resourceExhausted (memory).
    Result<H264Picture> encode(const render::Picture& picture, std::size_t mostBytes, bool key);

  private:
    struct Stream;
    std::unique_ptr<Stream> stream_;
};

}  // namespace mote::server
