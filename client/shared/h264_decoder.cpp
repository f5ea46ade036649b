// SPDX-License-Identifier: GPL-3.0-or-later
//
// H264Decoder (decode.h), by libavcodec. The library is loaded where it is there, when a picture or a
// connection first asks for it: half of what the viewer would need of other packages is its own, and without
// it pictures come as JPEG.
#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "client/shared/decode.h"
#include "protocol/wire/ycc.h"

extern "C" {
#include <libavcodec/avcodec.h>
}

namespace mote::client {
namespace {

/// What is used of libavcodec and libavutil, of the versions whose headers this was compiled with: functions
/// under their own names.
class AvLibrary {
  public:
    /// Null where they are not on this machine.
    static const AvLibrary* here() {
        static const AvLibrary library;
        return library.complete_ ? &library : nullptr;
    }

  private:
    static void* load(const char* name, int version) {
        return dlopen(fmt::format("lib{}.so.{}", name, version).c_str(), RTLD_LAZY | RTLD_LOCAL);
    }
    template <class Function>
    Function find(void* library, const char* name) {
        void* const found = library != nullptr ? dlsym(library, name) : nullptr;
        complete_ = complete_ && found != nullptr;
        return reinterpret_cast<Function>(found);
    }

    bool complete_ = true;
    void* codec_ = load("avcodec", LIBAVCODEC_VERSION_MAJOR);
    void* util_ = load("avutil", LIBAVUTIL_VERSION_MAJOR);

  public:
#define MOTE_FIND(library, name) decltype(&::name) name = find<decltype(&::name)>(library, #name)
    MOTE_FIND(codec_, avcodec_find_decoder);
    MOTE_FIND(codec_, avcodec_alloc_context3);
    MOTE_FIND(codec_, avcodec_free_context);
    MOTE_FIND(codec_, avcodec_open2);
    MOTE_FIND(codec_, avcodec_send_packet);
    MOTE_FIND(codec_, avcodec_receive_frame);
    MOTE_FIND(codec_, av_packet_alloc);
    MOTE_FIND(codec_, av_packet_free);
    MOTE_FIND(codec_, av_packet_unref);
    MOTE_FIND(codec_, av_new_packet);
    MOTE_FIND(util_, av_frame_alloc);
    MOTE_FIND(util_, av_frame_free);
    MOTE_FIND(util_, av_log_set_level);
#undef MOTE_FIND
};

/// Frees what the library made: there is none without it.
struct FreeAv {
    void operator()(AVCodecContext* context) const { AvLibrary::here()->avcodec_free_context(&context); }
    void operator()(AVFrame* frame) const { AvLibrary::here()->av_frame_free(&frame); }
    void operator()(AVPacket* packet) const { AvLibrary::here()->av_packet_free(&packet); }
};

Error outOfMemory() {
    return {ErrorCode::resourceExhausted, "frame", "there is not enough memory to decode the picture"};
}

bool isWhole(const AVFrame& frame) {
    const bool format = frame.format == AV_PIX_FMT_YUV420P || frame.format == AV_PIX_FMT_YUVJ420P;
    return format && frame.decode_error_flags == 0 && (frame.flags & AV_FRAME_FLAG_CORRUPT) == 0;
}

}  // namespace

struct H264Decoder::Stream {
    explicit Stream(const AvLibrary& library) : av(library) {}

    const AvLibrary& av;
    std::unique_ptr<AVCodecContext, FreeAv> context = nullptr;
    std::unique_ptr<AVFrame, FreeAv> frame{av.av_frame_alloc()};
    std::unique_ptr<AVPacket, FreeAv> packet{av.av_packet_alloc()};

    Status open(std::uint32_t width, std::uint32_t height) {
        av.av_log_set_level(AV_LOG_QUIET);  // damage is told by an Error
        const AVCodec* codec = av.avcodec_find_decoder(AV_CODEC_ID_H264);
        if (!codec) return Error{ErrorCode::unsupported, "frame", "libavcodec has no H.264 decoder here"};
        context.reset(av.avcodec_alloc_context3(codec));
        if (!context || !frame || !packet) return outOfMemory();
        context->thread_count = 1;
        context->flags |= AV_CODEC_FLAG_LOW_DELAY;
        context->err_recognition = AV_EF_EXPLODE | AV_EF_BITSTREAM | AV_EF_BUFFER;
        context->error_concealment = 0;
        // No stream takes more memory than its message told: sides up to the next macroblocks, and a few
        // more.
        context->max_pixels = (std::int64_t{width} + 64) * (std::int64_t{height} + 64);
        if (av.avcodec_open2(context.get(), codec, nullptr) < 0) return outOfMemory();
        return success();
    }

    /// Leaves the picture in `frame`.
    Status decode(std::span<const std::uint8_t> payload) {
        if (payload.empty() || payload.size() > INT32_MAX / 2)
            return corrupt("frame", "the picture is no H.264");
        // Decoders read beyond the end: libavcodec's own buffers are padded for it.
        if (av.av_new_packet(packet.get(), static_cast<int>(payload.size())) < 0) return outOfMemory();
        std::copy(payload.begin(), payload.end(), packet->data);
        const int sent = av.avcodec_send_packet(context.get(), packet.get());
        av.av_packet_unref(packet.get());
        if (sent < 0 || av.avcodec_receive_frame(context.get(), frame.get()) < 0 || !isWhole(*frame)) {
            return corrupt("frame", "the picture is damaged: it is not one whole H.264 picture");
        }
        return success();
    }
};

H264Decoder::H264Decoder() = default;
H264Decoder::~H264Decoder() = default;

bool H264Decoder::available() {
    const auto* const av = AvLibrary::here();
    return av != nullptr && av->avcodec_find_decoder(AV_CODEC_ID_H264) != nullptr;
}

Result<FramePixels> H264Decoder::decode(std::uint32_t width, std::uint32_t height, bool key,
                                        std::span<const std::uint8_t> payload) {
    auto stream = std::move(stream_);
    if (key) {
        const auto* const av = AvLibrary::here();
        if (av == nullptr) return Error{ErrorCode::unsupported, "frame", "libavcodec is not on this machine"};
        stream = std::make_unique<Stream>(*av);
        MOTE_RETURN_IF_ERROR(stream->open(width, height));
    }
    if (!stream) return Error{ErrorCode::cancelled, "frame", "it needs a picture that was not decoded"};
    MOTE_RETURN_IF_ERROR(stream->decode(payload));
    const AVFrame& frame = *stream->frame;
    if (frame.width != static_cast<int>(width + width % 2) ||
        frame.height != static_cast<int>(height + height % 2)) {
        return corrupt("frame", "the picture has another size than its message says");
    }
    FramePixels pixels{width, height, proto::SRGB8, {}};
    pixels.bytes.resize(std::size_t{width} * height * 4);
    const wire::YccPicture<const std::uint8_t> ycc{{frame.data[0], frame.data[1], frame.data[2]},
                                                   {frame.linesize[0], frame.linesize[1], frame.linesize[2]}};
    wire::yccToRgba(width, ycc, pixels.bytes);
    stream_ = std::move(stream);
    return pixels;
}

}  // namespace mote::client
