// SPDX-License-Identifier: GPL-3.0-or-later
//
// Owners of what libavcodec allocates, for who encodes and who decodes. Who includes it links the library.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
}

#include <memory>

namespace mote::wire {

struct FreeAv {
    void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
    void operator()(AVFrame* frame) const { av_frame_free(&frame); }
    void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};

using CodecOwner = std::unique_ptr<AVCodecContext, FreeAv>;
using FrameOwner = std::unique_ptr<AVFrame, FreeAv>;
using PacketOwner = std::unique_ptr<AVPacket, FreeAv>;

}  // namespace mote::wire
