// SPDX-License-Identifier: GPL-3.0-or-later
//
// VideoStream: frames of libavcodec's kind into a file of libavformat's, of a size, rate and quality that
// have been checked. The same frames give the same bytes on any machine with the same libraries: a fixed
// number of threads, no choice by processor, no dates or versions. One owner, one thread at a time; it has
// threads of its own.
#pragma once

extern "C" {
#include <libavformat/avformat.h>
}

#include <filesystem>
#include <memory>
#include <string>

#include "client/frames/video/video_settings.h"
#include "protocol/base/error.h"
#include "protocol/wire/av_owners.h"

namespace mote::client {

// The owner of what libavformat allocates, and its error numbers as ours. For the sources of this folder;
// plain functions, any thread.

/// With the file that it writes, whose own errors come too late to be told here.
struct FreeOutput {
    void operator()(AVFormatContext* context) const {
        avio_closep(&context->pb);
        avformat_free_context(context);
    }
};

using wire::CodecOwner;
using wire::FrameOwner;
using wire::PacketOwner;
using OutputOwner = std::unique_ptr<AVFormatContext, FreeOutput>;

/// A negative code of libav about the film `where`: errno's own errors, or internal with libav's words.
Error libavError(int code, const std::string& where);

class VideoStream {
  public:
    /// Writes into `file`, which is there; errors name `where`. Errors: unsupported (the encoder takes no
    /// such film), resourceExhausted, and those of the system.
    static Result<std::unique_ptr<VideoStream>> open(const std::filesystem::path& file, std::string where,
                                                     const VideoSettings& settings);

    ~VideoStream();
    VideoStream(const VideoStream&) = delete;
    VideoStream& operator=(const VideoStream&) = delete;

    /// The frame to be filled before each encode(). Errors: resourceExhausted.
    Result<AVFrame*> frame();
    /// Errors: those of the system (a full disk), internal.
    Status encode();
    /// The end of the file. Errors: as of encode.
    Status finish();

  private:
    VideoStream(std::string where, const VideoSettings& settings);
    Status openEncoder();
    Status openFile(const std::filesystem::path& file);
    Status send(const AVFrame* frame);
    Status write(AVPacket& packet);
    /// Where frame `index` lies, in the encoder's unit of time.
    std::int64_t timeOf(std::int64_t index) const;
    Error failed(int code) const;

    std::string where_;
    VideoSettings settings_;
    AVRational rate_;  ///< frames a second
    CodecOwner encoder_;
    OutputOwner output_;
    FrameOwner frame_;
    PacketOwner packet_;
    std::int64_t frames_ = 0;  ///< encoded so far
    bool open_ = false;        ///< the file has its beginning and not its end
};

}  // namespace mote::client
