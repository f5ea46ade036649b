// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/frame_encoder.h"

extern "C" {
#include <libavutil/opt.h>
}

#include <algorithm>
#include <cstring>

#include "protocol/base/mote_check.h"
#include "protocol/wire/av_owners.h"
#include "protocol/wire/row_filter.h"
#include "protocol/wire/ycc.h"
#include "server/encode/encode.h"

namespace mote::server {
namespace {

// Only names the unit of the rate control: a frame's budget times this is the stream's rate.
constexpr int nominalRate = 30;
constexpr std::size_t mostFrameBytes = std::size_t{8} << 20;  // the rate must fit into an int
constexpr const char* crf = "18";  // if the link allows more than that, the picture is good enough

int evenSide(std::uint32_t side) {
    return static_cast<int>(side + side % 2);
}

Error failed(int code) {
    if (code == AVERROR(ENOMEM)) return outOfMemory();
    char text[AV_ERROR_MAX_STRING_SIZE] = {};
    av_strerror(code, text, sizeof text);
    return {ErrorCode::internal, "frame", std::string("H.264: ") + text};
}

/// A buffer of one frame: what a frame does not use, the next must not spend.
void limit(AVCodecContext& context, std::size_t bytes) {
    const int bits = static_cast<int>(8 * bytes);
    context.rc_max_rate = std::int64_t{bits} * nominalRate;
    context.rc_buffer_size = bits;
}

void describe(AVCodecContext& context, std::uint32_t width, std::uint32_t height) {
    context.width = evenSide(width);
    context.height = evenSide(height);
    context.pix_fmt = AV_PIX_FMT_YUV420P;
    context.color_range = AVCOL_RANGE_JPEG;
    context.colorspace = AVCOL_SPC_BT709;
    context.color_primaries = AVCOL_PRI_BT709;
    context.color_trc = AVCOL_TRC_IEC61966_2_1;
    context.time_base = {1, nominalRate};
    context.gop_size = 1 << 30;  // key frames on demand only
    context.max_b_frames = 0;
    context.thread_count = 1;  // the other cores render
}

/// What no lossless picture exceeds by much: a link that carries this needs no closer look.
std::size_t rawBytes(const render::Picture& picture) {
    return std::size_t{picture.width} * picture.height * wire::filteredPixelSize(wireFormat(picture.format));
}

// Shares of the budget: the first lossless picture must fit with room to spare, the next ones must just fit.
constexpr double toBegin = 0.8;
constexpr double toStay = 1.1;

}  // namespace

struct H264Encoder::Stream {
    std::uint32_t width = 0, height = 0;
    wire::CodecOwner context;
    wire::FrameOwner frame;
    wire::PacketOwner packet;
    bool fresh = true;

    Status open(std::uint32_t pictureWidth, std::uint32_t pictureHeight, std::size_t mostBytes) {
        av_log_set_level(AV_LOG_QUIET);
        const AVCodec* codec = avcodec_find_encoder_by_name("libx264");
        if (!codec) return Error{ErrorCode::unsupported, "frame", "libavcodec has no libx264 here"};
        width = pictureWidth;
        height = pictureHeight;
        context.reset(avcodec_alloc_context3(codec));
        frame.reset(av_frame_alloc());
        packet.reset(av_packet_alloc());
        if (!context || !frame || !packet) return outOfMemory();
        describe(*context, width, height);
        limit(*context, mostBytes);
        for (const auto& [name, value] :
             {std::pair{"preset", "ultrafast"}, {"tune", "zerolatency"}, {"crf", crf}, {"forced-idr", "1"}}) {
            if (const int code = av_opt_set(context->priv_data, name, value, 0); code < 0)
                return failed(code);
        }
        if (avcodec_open2(context.get(), codec, nullptr) < 0) {
            return Error{ErrorCode::unsupported, "frame", "H.264 cannot encode a picture of this size"};
        }
        frame->format = context->pix_fmt;
        frame->width = context->width;
        frame->height = context->height;
        const int code = av_frame_get_buffer(frame.get(), 0);
        return code < 0 ? Status(failed(code)) : success();
    }

    /// The column and the row that even sides may add repeat their neighbours.
    void fill(const render::Picture& picture) {
        const auto& f = *frame;
        const wire::YccPicture<std::uint8_t> ycc{{f.data[0], f.data[1], f.data[2]},
                                                 {f.linesize[0], f.linesize[1], f.linesize[2]}};
        wire::rgbaToYcc(width, picture.pixels, ycc);
        if (width % 2 == 1) {
            for (std::size_t y = 0; y < height; ++y) ycc.row(0, y)[width] = ycc.row(0, y)[width - 1];
        }
        if (height % 2 == 1) {
            std::memcpy(ycc.row(0, height), ycc.row(0, height - 1), static_cast<std::size_t>(f.width));
        }
    }

    Result<H264Picture> encode(const render::Picture& picture, std::size_t mostBytes, bool key) {
        if (const int code = av_frame_make_writable(frame.get()); code < 0) return failed(code);
        fill(picture);
        limit(*context, mostBytes);
        frame->pts = std::exchange(fresh, false) ? 0 : frame->pts + 1;
        frame->pict_type = key ? AV_PICTURE_TYPE_I : AV_PICTURE_TYPE_NONE;
        if (const int code = avcodec_send_frame(context.get(), frame.get()); code < 0) return failed(code);
        if (const int code = avcodec_receive_packet(context.get(), packet.get()); code < 0)
            return failed(code);
        H264Picture made{{packet->data, packet->data + packet->size}, (packet->flags & AV_PKT_FLAG_KEY) != 0};
        av_packet_unref(packet.get());
        return made;
    }
};

H264Encoder::H264Encoder() = default;
H264Encoder::~H264Encoder() = default;

Result<H264Picture> H264Encoder::encode(const render::Picture& picture, std::size_t mostBytes, bool key) {
    MOTE_CHECK(picture.format == render::PixelFormat::srgb8);
    mostBytes = std::clamp(mostBytes, leastBytes, mostFrameBytes);
    if (!stream_ || stream_->width != picture.width || stream_->height != picture.height) {
        stream_ = std::make_unique<Stream>();
        if (const auto status = stream_->open(picture.width, picture.height, mostBytes); !status.ok()) {
            stream_.reset();
            return status.error();
        }
    }
    auto made = stream_->encode(picture, mostBytes, key);
    if (!made.ok()) stream_.reset();
    return made;
}

proto::Frame::Encoding chooseEncoding(const EncodingTarget& target, const PictureFacts& picture) {
    if (target.jpeg) return proto::Frame::JPEG;
    if (picture.exact) return proto::Frame::ZSTD;
    if (target.measured && target.frameBytes) {
        const double most =
            (picture.wasLossless ? toStay : toBegin) * static_cast<double>(*target.frameBytes);
        if (static_cast<double>(picture.losslessBytes) <= most) return proto::Frame::ZSTD;
    }
    return target.h264 ? proto::Frame::H264 : proto::Frame::JPEG;
}

Result<EncodedPicture> FrameEncoder::encode(const render::Picture& picture, bool exact,
                                            const EncodingTarget& target) {
    PictureFacts facts{exact, 0, wasLossless_};
    if (!exact && target.frameBytes && *target.frameBytes < 2 * rawBytes(picture)) {
        MOTE_ASSIGN_OR_RETURN(facts.losslessBytes, lossless_.expectedBytes(picture));
    }
    auto encoding = chooseEncoding(target, facts);
    if (!exact) wasLossless_ = encoding == proto::Frame::ZSTD;
    if (encoding == proto::Frame::H264 && h264Works_) {
        auto made = encodeH264(picture, target);
        if (made.ok() || made.error().code != ErrorCode::unsupported) return made;
        h264Works_ = false;
    }
    if (encoding == proto::Frame::H264) encoding = proto::Frame::JPEG;
    MOTE_ASSIGN_OR_RETURN(auto payload,
                          encoding == proto::Frame::ZSTD ? lossless_.encode(picture) : encodeJpeg(picture));
    return EncodedPicture{encoding, false, std::move(payload)};
}

Result<EncodedPicture> FrameEncoder::encodeH264(const render::Picture& picture,
                                                const EncodingTarget& target) {
    const std::size_t most = target.frameBytes.value_or(unmeasuredFrameBytes);
    MOTE_ASSIGN_OR_RETURN(auto made, h264_.encode(picture, most, keyWanted_.exchange(false)));
    return EncodedPicture{proto::Frame::H264, made.key, std::move(made.payload)};
}

}  // namespace mote::server
