// SPDX-License-Identifier: GPL-3.0-or-later
//
// FrameEncoder: turns the pictures of one client into payloads, each in the encoding that its link asks for.
// One owner, one thread at a time, in the order in which the frames are sent: H.264 is a stream.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "server/encode/encoding_choice.h"
#include "server/encode/h264_encoder.h"
#include "server/encode/lossless_encoder.h"

namespace mote::server {

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
