// SPDX-License-Identifier: GPL-3.0-or-later
//
// FrameEncoder: turns the pictures of one client into payloads, each in the encoding that its link asks for.
// One owner, one thread at a time, in the order in which the frames are sent: H.264 is a stream.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "server/encode/encode.h"
#include "server/render/plan/picture.h"

namespace mote::server {

struct H264Picture {
    std::vector<std::uint8_t> payload;  ///< Annex B
    bool key = false;                   ///< needs none before it
};

/// Makes pictures a stream of H.264 in which a picture is decoded as soon as it is there (x264, ultrafast,
/// zero latency) and none is larger than the link's share. Colours: protocol/wire/ycc.h. The only place of
/// the server that knows libavcodec.
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

/// What is known of one client, and of the link to it.
struct EncodingTarget {
    bool measured = false;  ///< it says what it receives; others get JPEG in motion, lossless at rest
    bool h264 = false;      ///< it decodes that
    /// What a frame in motion may hold, so that the link carries 30 a second; none: not measured yet.
    std::optional<std::size_t> frameBytes;
    bool jpeg = false;  ///< nothing but that: small pictures that are kept
};

struct PictureFacts {
    bool exact = false;             ///< the picture at rest, or one that was asked for as such
    std::size_t losslessBytes = 0;  ///< expected
    bool wasLossless = false;       ///< the picture before it: a hand should not see it flicker
};

/// A frame's bytes until the link is measured: few enough for all but the thinnest.
inline constexpr std::size_t unmeasuredFrameBytes = 48 << 10;

/// Which encoding a picture gets: lossless wherever the link carries it, H.264 below that, JPEG for clients
/// without. JPEG is nowhere the best for others: smooth pictures, where it is good, H.264 packs still better.
/// Pure; measured by bench-encode.
proto::Frame::Encoding chooseEncoding(const EncodingTarget& target, const PictureFacts& picture);

struct EncodedPicture {
    proto::Frame::Encoding encoding = proto::Frame::ENCODING_UNSPECIFIED;
    bool key = false;  ///< H264: needs none before it
    std::vector<std::uint8_t> payload;
};

class FrameEncoder {
  public:
    /// `exact`: as in PictureFacts. Errors: internal, resourceExhausted (memory).
    Result<EncodedPicture> encode(const render::Picture& picture, bool exact, const EncodingTarget& target);
    /// The client's decoder lost its way. Any thread.
    void wantKey() { keyWanted_ = true; }

  private:
    Result<EncodedPicture> encodeH264(const render::Picture& picture, const EncodingTarget& target);

    LosslessEncoder lossless_;
    H264Encoder h264_;
    std::atomic<bool> keyWanted_ = false;
    bool wasLossless_ = false;
    bool h264Works_ = true;
};

}  // namespace mote::server
