// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/decode.h"

#include <fmt/format.h>
#include <turbojpeg.h>
#include <zstd.h>
#include <algorithm>
#include <memory>

#include "protocol/scene/view.h"
#include "protocol/wire/av_owners.h"
#include "protocol/wire/row_filter.h"
#include "protocol/wire/ycc.h"

namespace mote::client {
namespace {

Status checkSize(const proto::Frame& message) {
    const std::uint64_t width = message.width(), height = message.height();
    const bool sides = width >= 1 && width <= View::maxSide && height >= 1 && height <= View::maxSide;
    if (sides && width * height <= View::maxPixels) return success();
    return corrupt("frame", fmt::format("the server sent a picture of {} x {} pixels", width, height));
}

Result<FramePixels> decodeZstd(FramePixels pixels, std::span<const std::uint8_t> payload) {
    const std::size_t count = std::size_t{pixels.width} * pixels.height;
    const std::size_t size = count * wire::filteredPixelSize(pixels.format);
    const auto stated = ZSTD_getFrameContentSize(payload.data(), payload.size());
    if (stated == ZSTD_CONTENTSIZE_ERROR) return corrupt("frame", "the picture's bytes are not zstd");
    if (stated != ZSTD_CONTENTSIZE_UNKNOWN && stated != size) {
        return corrupt("frame",
                       fmt::format("the picture holds {} bytes where its size asks for {}", stated, size));
    }
    const auto filtered = std::make_unique_for_overwrite<std::uint8_t[]>(size);
    const std::size_t got = ZSTD_decompress(filtered.get(), size, payload.data(), payload.size());
    if (ZSTD_isError(got)) {
        return corrupt("frame", fmt::format("the picture is damaged: {}", ZSTD_getErrorName(got)));
    }
    if (got != size) {
        return corrupt("frame",
                       fmt::format("the picture holds {} bytes where its size asks for {}", got, size));
    }
    pixels.bytes.resize(count * bytesPerPixel(pixels.format));
    wire::unfilterRows(pixels.format, pixels.width, {filtered.get(), size}, pixels.bytes);
    return pixels;
}

Result<FramePixels> decodeJpeg(FramePixels pixels, std::span<const std::uint8_t> payload) {
    if (pixels.format != proto::SRGB8) return corrupt("frame", "a JPEG picture cannot hold linear halves");
    const std::unique_ptr<void, int (*)(tjhandle)> jpeg(tjInitDecompress(), tjDestroy);
    if (!jpeg) return Error{ErrorCode::internal, "frame", "libjpeg-turbo does not start"};
    int width = 0, height = 0, subsampling = 0, colorspace = 0;
    if (tjDecompressHeader3(jpeg.get(), payload.data(), payload.size(), &width, &height, &subsampling,
                            &colorspace) != 0) {
        return corrupt("frame", fmt::format("the picture is not JPEG: {}", tjGetErrorStr2(jpeg.get())));
    }
    if (static_cast<std::uint32_t>(width) != pixels.width ||
        static_cast<std::uint32_t>(height) != pixels.height) {
        return corrupt("frame", fmt::format("the JPEG picture is {} x {}, its message says {} x {}", width,
                                            height, pixels.width, pixels.height));
    }
    pixels.bytes.resize(std::size_t{pixels.width} * pixels.height * 4);
    // A warning (a truncated file, say) counts as damage: half a picture is a wrong picture.
    if (tjDecompress2(jpeg.get(), payload.data(), payload.size(), pixels.bytes.data(), width, 0, height,
                      TJPF_RGBA, 0) != 0) {
        return corrupt("frame", fmt::format("the picture is damaged: {}", tjGetErrorStr2(jpeg.get())));
    }
    return pixels;
}

}  // namespace

std::size_t bytesPerPixel(proto::PixelFormat format) {
    return wire::pixelSize(format);
}

Result<FramePixels> decodeFrame(const proto::Frame& message, std::span<const std::uint8_t> payload) {
    MOTE_RETURN_IF_ERROR(checkSize(message));
    FramePixels pixels{message.width(), message.height(), message.format(), {}};
    if (message.encoding() == proto::Frame::DOCUMENT) {
        pixels.format = proto::PIXEL_FORMAT_UNSPECIFIED;
        pixels.bytes.assign(payload.begin(), payload.end());
        return pixels;
    }
    if (pixels.format == proto::PIXEL_FORMAT_UNSPECIFIED) pixels.format = proto::SRGB8;
    if (bytesPerPixel(pixels.format) == 0) {
        return Error{ErrorCode::unsupported, "frame",
                     "the server sent a pixel format that is not known here"};
    }
    switch (message.encoding()) {
        case proto::Frame::JPEG:
            return decodeJpeg(std::move(pixels), payload);
        case proto::Frame::ZSTD:
            return decodeZstd(std::move(pixels), payload);
        default:
            return Error{ErrorCode::unsupported, "frame",
                         "the server sent an encoding that is not known here"};
    }
}

Result<FramePixels> FrameDecoder::decode(const proto::Frame& message, std::span<const std::uint8_t> payload) {
    if (message.encoding() != proto::Frame::H264) return decodeFrame(message, payload);
    wantsKey_ = true;
    MOTE_RETURN_IF_ERROR(checkSize(message));
    if (message.format() != proto::SRGB8)
        return corrupt("frame", "an H.264 picture cannot hold linear halves");
    auto pixels = h264_.decode(message.width(), message.height(), message.key(), payload);
    wantsKey_ = !pixels.ok();
    return pixels;
}

namespace {

Error outOfMemory() {
    return {ErrorCode::resourceExhausted, "frame", "there is not enough memory to decode the picture"};
}

bool isWhole(const AVFrame& frame) {
    const bool format = frame.format == AV_PIX_FMT_YUV420P || frame.format == AV_PIX_FMT_YUVJ420P;
    return format && frame.decode_error_flags == 0 && (frame.flags & AV_FRAME_FLAG_CORRUPT) == 0;
}

}  // namespace

struct H264Decoder::Stream {
    wire::CodecOwner context;
    wire::FrameOwner frame{av_frame_alloc()};
    wire::PacketOwner packet{av_packet_alloc()};

    Status open(std::uint32_t width, std::uint32_t height) {
        av_log_set_level(AV_LOG_QUIET);  // damage is told by an Error
        const AVCodec* codec = avcodec_find_decoder(AV_CODEC_ID_H264);
        if (!codec) return Error{ErrorCode::unsupported, "frame", "libavcodec has no H.264 decoder here"};
        context.reset(avcodec_alloc_context3(codec));
        if (!context || !frame || !packet) return outOfMemory();
        context->thread_count = 1;
        context->flags |= AV_CODEC_FLAG_LOW_DELAY;
        context->err_recognition = AV_EF_EXPLODE | AV_EF_BITSTREAM | AV_EF_BUFFER;
        context->error_concealment = 0;
        // No stream takes more memory than its message told: sides up to the next macroblocks, and a few
        // more.
        context->max_pixels = (std::int64_t{width} + 64) * (std::int64_t{height} + 64);
        if (avcodec_open2(context.get(), codec, nullptr) < 0) return outOfMemory();
        return success();
    }

    /// Leaves the picture in `frame`.
    Status decode(std::span<const std::uint8_t> payload) {
        if (payload.empty() || payload.size() > INT32_MAX / 2)
            return corrupt("frame", "the picture is no H.264");
        // Decoders read beyond the end: libavcodec's own buffers are padded for it.
        if (av_new_packet(packet.get(), static_cast<int>(payload.size())) < 0) return outOfMemory();
        std::copy(payload.begin(), payload.end(), packet->data);
        const int sent = avcodec_send_packet(context.get(), packet.get());
        av_packet_unref(packet.get());
        if (sent < 0 || avcodec_receive_frame(context.get(), frame.get()) < 0 || !isWhole(*frame)) {
            return corrupt("frame", "the picture is damaged: it is not one whole H.264 picture");
        }
        return success();
    }
};

H264Decoder::H264Decoder() = default;
H264Decoder::~H264Decoder() = default;

bool H264Decoder::available() {
    return avcodec_find_decoder(AV_CODEC_ID_H264) != nullptr;
}

Result<FramePixels> H264Decoder::decode(std::uint32_t width, std::uint32_t height, bool key,
                                        std::span<const std::uint8_t> payload) {
    auto stream = std::move(stream_);
    if (key) {
        stream = std::make_unique<Stream>();
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
