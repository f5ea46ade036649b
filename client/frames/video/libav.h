// SPDX-License-Identifier: GPL-3.0-or-later
//
// Owners of what libavformat and libavcodec allocate, and their error numbers as ours. For the sources of
// this folder; plain functions, any thread.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include <memory>
#include <string>

#include "protocol/scene/error.h"

namespace mote::client {

struct FreeCodec {
    void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
};
struct FreeFrame {
    void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};
struct FreePacket {
    void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
/// With the file that it writes, whose own errors come too late to be told here.
struct FreeOutput {
    void operator()(AVFormatContext* context) const {
        avio_closep(&context->pb);
        avformat_free_context(context);
    }
};

using CodecOwner = std::unique_ptr<AVCodecContext, FreeCodec>;
using FrameOwner = std::unique_ptr<AVFrame, FreeFrame>;
using PacketOwner = std::unique_ptr<AVPacket, FreePacket>;
using OutputOwner = std::unique_ptr<AVFormatContext, FreeOutput>;

/// A negative code of libav about the film `where`: errno's own errors, or internal with libav's words.
Error libavError(int code, const std::string& where);

}  // namespace mote::client
