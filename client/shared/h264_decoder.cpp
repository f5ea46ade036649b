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

/// What is used of libavcodec and libavutil, of the versions whose headers this was compiled with.
class AvLibrary {
  public:
    /// Null where they are not on this machine.
    static const AvLibrary* here() {
        static const AvLibrary library;
        return library.complete_ ? &library : nullptr;
    }

    decltype(&::avcodec_find_decoder) findDecoder = nullptr;
    decltype(&::avcodec_alloc_context3) allocContext = nullptr;
    decltype(&::avcodec_free_context) freeContext = nullptr;
    decltype(&::avcodec_open2) open = nullptr;
    decltype(&::avcodec_send_packet) sendPacket = nullptr;
    decltype(&::avcodec_receive_frame) receiveFrame = nullptr;
    decltype(&::av_packet_alloc) allocPacket = nullptr;
    decltype(&::av_packet_free) freePacket = nullptr;
    decltype(&::av_packet_unref) unrefPacket = nullptr;
    decltype(&::av_new_packet) newPacket = nullptr;
    decltype(&::av_frame_alloc) allocFrame = nullptr;
    decltype(&::av_frame_free) freeFrame = nullptr;
    decltype(&::av_log_set_level) setLogLevel = nullptr;

  private:
    AvLibrary() {
        void* const codec = load("avcodec", LIBAVCODEC_VERSION_MAJOR);
        void* const util = load("avutil", LIBAVUTIL_VERSION_MAJOR);
        complete_ = find(codec, "avcodec_find_decoder", findDecoder) &&
                    find(codec, "avcodec_alloc_context3", allocContext) &&
                    find(codec, "avcodec_free_context", freeContext) && find(codec, "avcodec_open2", open) &&
                    find(codec, "avcodec_send_packet", sendPacket) &&
                    find(codec, "avcodec_receive_frame", receiveFrame) &&
                    find(codec, "av_packet_alloc", allocPacket) &&
                    find(codec, "av_packet_free", freePacket) &&
                    find(codec, "av_packet_unref", unrefPacket) && find(codec, "av_new_packet", newPacket) &&
                    find(util, "av_frame_alloc", allocFrame) && find(util, "av_frame_free", freeFrame) &&
                    find(util, "av_log_set_level", setLogLevel);
    }

    static void* load(const char* name, int version) {
        return dlopen(fmt::format("lib{}.so.{}", name, version).c_str(), RTLD_LAZY | RTLD_LOCAL);
    }

    template <class Function>
    static bool find(void* library, const char* name, Function& function) {
        if (library != nullptr) function = reinterpret_cast<Function>(dlsym(library, name));
        return function != nullptr;
    }

    bool complete_ = false;
};

/// Frees what the library made: there is none without it.
struct FreeAv {
    void operator()(AVCodecContext* context) const { AvLibrary::here()->freeContext(&context); }
    void operator()(AVFrame* frame) const { AvLibrary::here()->freeFrame(&frame); }
    void operator()(AVPacket* packet) const { AvLibrary::here()->freePacket(&packet); }
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
    std::unique_ptr<AVFrame, FreeAv> frame{av.allocFrame()};
    std::unique_ptr<AVPacket, FreeAv> packet{av.allocPacket()};

    Status open(std::uint32_t width, std::uint32_t height) {
        av.setLogLevel(AV_LOG_QUIET);  // damage is told by an Error
        const AVCodec* codec = av.findDecoder(AV_CODEC_ID_H264);
        if (!codec) return Error{ErrorCode::unsupported, "frame", "libavcodec has no H.264 decoder here"};
        context.reset(av.allocContext(codec));
        if (!context || !frame || !packet) return outOfMemory();
        context->thread_count = 1;
        context->flags |= AV_CODEC_FLAG_LOW_DELAY;
        context->err_recognition = AV_EF_EXPLODE | AV_EF_BITSTREAM | AV_EF_BUFFER;
        context->error_concealment = 0;
        // No stream takes more memory than its message told: sides up to the next macroblocks, and a few
        // more.
        context->max_pixels = (std::int64_t{width} + 64) * (std::int64_t{height} + 64);
        if (av.open(context.get(), codec, nullptr) < 0) return outOfMemory();
        return success();
    }

    /// Leaves the picture in `frame`.
    Status decode(std::span<const std::uint8_t> payload) {
        if (payload.empty() || payload.size() > INT32_MAX / 2)
            return corrupt("frame", "the picture is no H.264");
        // Decoders read beyond the end: libavcodec's own buffers are padded for it.
        if (av.newPacket(packet.get(), static_cast<int>(payload.size())) < 0) return outOfMemory();
        std::copy(payload.begin(), payload.end(), packet->data);
        const int sent = av.sendPacket(context.get(), packet.get());
        av.unrefPacket(packet.get());
        if (sent < 0 || av.receiveFrame(context.get(), frame.get()) < 0 || !isWhole(*frame)) {
            return corrupt("frame", "the picture is damaged: it is not one whole H.264 picture");
        }
        return success();
    }
};

H264Decoder::H264Decoder() = default;
H264Decoder::~H264Decoder() = default;

bool H264Decoder::available() {
    const auto* const av = AvLibrary::here();
    return av != nullptr && av->findDecoder(AV_CODEC_ID_H264) != nullptr;
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
